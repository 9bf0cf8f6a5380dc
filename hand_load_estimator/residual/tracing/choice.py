"""Choose among candidates: the simplest that is as good as the best, and what stands beside it."""

from ...effects import LINK_INERTIA
from ..diagnosis import UNKNOWN
from .candidate import alike, Step, tied
from .confusable import CLOSE
from .hypotheses import ONE_CAUSE
from .hypothesis import looks_like_another


def chosen_step(best, ranked, needed, every):
    """
    Return the Step of the best Candidate, or of a simpler one that is as good.

    ranked: adequate Candidates; needed [nats]; every: Candidates of single effects, those that
    are no adequate explanation too, for a runner-up where no other is.
    """
    rivals = [c for c in ranked if c is not best and _instead(c, best)]
    # Of equals, the one that needs the fewest parameters; a pair that nothing tells apart.
    equal = [c for c in rivals if best.name != UNKNOWN and (
        tied(best, c) or looks_like(best, c))]
    simplest = min([best, *equal], key=lambda c: (c.size, -c.gain))
    others = [best, *(c for c in rivals if alike(best, c))]
    # Much of a link can be a part of the one before it.
    alternatives = tuple(c for c in others if c.name != UNKNOWN and (
        c.name != simplest.name or c.name == LINK_INERTIA.name and c.joints != simplest.joints))
    lesser = sorted((c for c in every if _instead(c, simplest)), key=lambda c: -c.gain)
    runner_up = next((c for c in [best, *rivals, *lesser] if _other(c, simplest)), None)
    return Step(simplest, alternatives, runner_up, needed)


def looks_like(best, other):
    """Tell whether a Candidate has a figure at its end, with which it is as good as another."""
    def at_end(candidate):
        return any(looks_like_another(hypothesis) for hypothesis, _ in candidate.parts)
    return at_end(best) and not at_end(other) and other.gain > CLOSE * best.gain


def _instead(candidate, best):
    """Tell whether a Candidate might stand in the place of another."""
    same = all(getattr(candidate, what) == getattr(best, what)
               for what in ('name', 'joints', 'common'))
    return candidate.name != UNKNOWN and not same \
        and bool(set(candidate.touched) & set(best.touched))


def _other(candidate, chosen):
    """Tell whether a Candidate explains anything, by another cause."""
    return candidate is not chosen and candidate.gain > 0.0 and (
        candidate.name != chosen.name or candidate.name not in ONE_CAUSE)
