"""Where friction that falls with temperature levels off."""

import numpy as np

from .effect import Shape

# Friction falls as the grease warms, but only to what dry contact leaves: measured curves flatten
# (Bittencourt and Axelsson 2014). Segmented regression (Muggeo 2003) finds where, in kelvin above
# the reference temperature; infinity is a straight line.
KNEE = Shape('knee', 'K', np.inf, (np.inf, 3.0, 5.0, 7.0, 10.0, 13.0, 17.0, 22.0, 28.0), 25.0)

# Below a knee the recordings must show the fall by itself, over so many kelvin, and above it
# so large a share of the time must lie: else a steeper fall to an earlier knee is the same.
_FALL, _LEVEL = 3.0, 0.02


def shows(warmth, knee):
    """Tell whether warmths (N,) [K] can tell a knee [K] from a straight line."""
    below = warmth[warmth < knee]
    return len(warmth) - len(below) > _LEVEL * len(warmth) and len(below) > _LEVEL * len(warmth) \
        and np.ptp(np.quantile(below, [0.02, 0.98])) >= _FALL


def falling_warmth(x, j, shape):
    """Return the warmth (N,) [K] of joint j, no more than its knee; colder it goes on."""
    return np.minimum(x.warmth[:, j], shape[KNEE.name])
