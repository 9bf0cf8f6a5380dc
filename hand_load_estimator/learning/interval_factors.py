"""
Factors that make stated standard deviations true, by how well a parameter is determined.

Early, when a parameter is hardly determined, and late, when the model's errors are all that is
left, a network errs differently: one factor for both would be too small for one and too large
for the other.
"""

import numpy as np

# log10 of the stated standard deviation over the prior's, at which factors are held.
LEVELS = tuple(-2.5 + 0.25 * k for k in range(11))
_SPACING, _PLACES = LEVELS[1] - LEVELS[0], np.arange(len(LEVELS))


def level_of(std, prior_std):
    """Return log10 (..., 10) of stated over prior standard deviations, both in shape order."""
    return np.log10(np.maximum(std / prior_std, 1e-9))


def factors_at(factors, level):
    """Return (10,) factors for one level (10,) from those at LEVELS (10, len(LEVELS))."""
    place = np.minimum(np.maximum((level - LEVELS[0]) / _SPACING, 0.0), len(LEVELS) - 1)
    # Linear between the two levels around it: both have a share that falls with the distance.
    shares = np.maximum(1.0 - np.abs(place[:, None] - _PLACES), 0.0)
    return (shares * factors).sum(axis=1)
