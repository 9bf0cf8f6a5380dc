"""Plain functions: any smooth function of one variable, for what no effect has a name for."""

import numpy as np

from ..diagnosis import UNKNOWN
from .hypothesis import Hypothesis

KNOTS = 32
# Knots are so far apart, as a share of all that they cover.
LEAST_APART = 1e-6
# What an unknown effect may be a function of; torque through the gear includes the load's.
VARIABLES = {'velocity': 'v', 'position': 'q', 'acceleration': 'a', 'gear torque': 'gear'}


def functions(residual, torque, j):
    """
    Yield hypotheses `unknown` of joint j: any smooth function of one of VARIABLES.

    residual: Residual; torque (n,): the joints' limits [Nm], which scale what is expected.
    """
    for variable, name in VARIABLES.items():
        values = getattr(residual.x, name)[:, j]
        columns = hats(values, KNOTS)
        if columns.shape[1] < 4:
            continue
        scale = np.full(columns.shape[1], 0.1 * torque[j])
        yield Hypothesis(UNKNOWN, j, {j: columns * scale}, scale, {}, variable)


def hats(values, knots):
    """Return (N, <= knots) piecewise linear functions over the quantiles of values (N,)."""
    places = np.unique(np.quantile(values, np.linspace(0.01, 0.99, knots)))
    # What a filter forgets comes to rest at 1e-300: no function has a slope for that.
    places = places[np.diff(places, prepend=-np.inf) > LEAST_APART * np.ptp(places)]
    if len(places) < 4:
        return np.zeros((len(values), 0))
    return np.stack([np.interp(values, places, row) for row in np.eye(len(places))], axis=1)
