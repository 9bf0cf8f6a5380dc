"""
Take back what a later effect explains by itself.

An effect that is chosen while another stands for half of it has the form of the other half only:
beside more viscous friction a lubricant that thins gently looks like one that thins at once.
"""

from dataclasses import replace

from ...effects import LATE
from ..diagnosis import UNKNOWN
from ..doubts.unfounded import EXACT
from .candidate import ahead, evaluated, joined, significant
from .finer_shape import searched_again
from .hypothesis import searched


def take_back(found, model, warmed, possible):
    """
    Drop the Step of Found that its newest explains, too, where it has its own finer form.

    model, warmed: as of Trace; possible(candidate): whether physics allows it and it matters.
    Returns the indices of the joints where anything has changed.
    """
    last = found.newest
    if last.expected or not _replaceable(last) or not searched(last.chosen.parts[0][0]):
        return set()
    for k, earlier in enumerate(found.steps[:-1]):
        if not _replaceable(earlier) or earlier.chosen.joints != last.chosen.joints:
            continue
        blocks = found.beside(last, earlier)
        alone = searched_again(last.chosen, blocks, model, found.residual, warmed)
        # With more figures it would explain as much of what is none of its own.
        plain = alone.size <= earlier.chosen.size + last.chosen.size
        if plain and possible(alone) and not _two(earlier, last, alone, blocks):
            found.put(replace(last, chosen=alone), last)
            found.drop(found.steps[k])
            return set(alone.touched)
    return set()


def _replaceable(step):
    # Of presliding most shows in reversals, which the blocks leave out.
    return len(step.chosen.joints) == 1 and step.chosen.name not in (
        LATE, UNKNOWN, 'presliding_hysteresis')


def _two(earlier, last, alone, blocks):
    """Tell whether two Steps explain surely more than what a form, never exact, leaves."""
    first = evaluated(earlier.chosen, blocks)
    second = evaluated(last.chosen, blocks.beside(first.columns))
    beyond = ahead(joined('both', (*first.parts, *second.parts)), alone)
    return beyond.gain > max(last.needed, EXACT ** 2 * alone.gain) and significant(beyond)
