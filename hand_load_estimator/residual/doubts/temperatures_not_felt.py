"""
Temperatures that the arm does not feel: friction no longer falls with them at most joints.

A sensor that reads something else, or another joint's, makes every effect of temperature doubtful:
what seems one at a joint makes up for what the model expected of a warmth that was none.
"""

from dataclasses import replace

import numpy as np

from ...effects import EFFECTS, NEEDS_TEMPERATURE
from ..diagnosis import CONFIRMED, SUSPECTED

# Of what the model had, less than this share is left where a joint does not feel its temperature.
FELT = 0.3
# At so many joints at least, and at half of those that warmed.
FEWEST = 2


def not_felt(findings, model, better, warmed):
    """
    Return (Findings, sentences): no effect of temperature is confirmed where most are gone.

    model, better: TorqueModels before and after; warmed: indices of joints whose temperature
    changed.
    """
    gone = [j for j in warmed if _gone(model, better, j)]
    doubted = [f.verdict == CONFIRMED and f.name in NEEDS_TEMPERATURE for f in findings]
    if len(gone) < FEWEST or 2 * len(gone) < len(warmed) or not any(doubted):
        return findings, ()
    names = ', '.join(model.robot.joints[j] for j in gone)
    return (tuple(replace(f, verdict=SUSPECTED) if d else f for f, d in zip(findings, doubted)),
            tuple(f'{", ".join(f.joints)}: {f.name} is only suspected, because friction of '
                  f'{names} hardly follows the temperatures recorded any more; look at the '
                  'sensors' for f, d in zip(findings, doubted) if d))


def _gone(model, better, j):
    """Tell whether friction of joint j followed its temperature, and hardly does any more."""
    old, new = (_slopes(m, j) for m in (model, better))
    return bool(old > 0.0 and new < FELT * old)


def _slopes(model, j):
    """Return the size of all that joint j's temperature changes, in units of its priors."""
    size = [np.abs(model.mean[where] / EFFECTS[use.name].std(model.robot.limits.torque[j]))
            for use, where in model.slices()
            if use.joint == j and use.name.startswith('temperature_dependent')]
    # What is linear in warmth: a curvature makes up for a slope.
    return float(sum(values[0] for values in size))
