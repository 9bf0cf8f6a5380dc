"""
Factors on standard deviations that a method states, as a function of the deviation stated.

How far a stated deviation is off depends on how sure it is: early answers rest on the prior, late
ones on what was learnt or measured.
"""

import numpy as np

# Stated deviations are parted into so many equally frequent ranges, each with its factor.
RANGES = 6
# Places of all parameters.
ALL = range(10)
# No logarithm of nothing, where thinned networks agree to the last bit.
LEAST_STD = 1e-9


def calibrated(std, picked, knots, factors):
    """
    Return std (..., 10) with the factors put on the parameters at places `picked`.

    knots (P, RANGES): logarithms of stated std, rising; factors (P, RANGES) there.
    """
    out = np.array(std, dtype=float)
    for place, x, y in zip(picked, knots, factors):
        stated = np.maximum(out[..., place], LEAST_STD)
        out[..., place] = stated * np.interp(np.log(stated), x, y)
    return out


def usable(knots, factors, parameters):
    """Tell whether knots and factors of so many parameters are a calibration."""
    shape = parameters, RANGES
    return bool(knots.shape == factors.shape == shape and np.isfinite(knots).all()
                and np.isfinite(factors).all() and (factors > 0.0).all())
