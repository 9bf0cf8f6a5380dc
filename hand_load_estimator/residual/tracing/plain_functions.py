"""Plain functions: any smooth function of one variable, for what no effect has a name for."""

import numpy as np

from ..diagnosis import UNKNOWN
from .hypothesis import Hypothesis

KNOTS = 32
# Knots are so far apart, as a share of all that they cover.
LEAST_APART = 1e-6
# What an unknown effect may be a function of; torque through the gear includes the load's, the
# drive's friction too.
TORQUES = {'gear torque': 'gear', 'drive torque': 'drive'}
VARIABLES = {'velocity': 'v', 'position': 'q', 'acceleration': 'a', **TORQUES}


def functions(residual, torque, j):
    """
    Yield hypotheses `unknown` of joint j: any smooth function of one of VARIABLES.

    residual: Residual; torque (n,): the joints' limits [Nm], which scale what is expected.
    """
    for variable, name in VARIABLES.items():
        columns = hats(getattr(residual.x, name)[:, j], KNOTS)
        if columns.shape[1]:
            yield _function(variable, columns, torque, j)


def functions_judged(residual, blocks, torque, j):
    """
    Yield (hypothesis as of functions, rows (N,) bool in which Blocks can judge it).

    Half of the corners are spread evenly: a peak at a speed that a joint only passes through lies
    between few quantiles. What only one fold has seen a function fitted to the others is a guess
    at: rows are those between corners between which two folds have been.
    """
    folds, counts = blocks.fold_of_rows(), blocks.weights[:, j] > 0.0
    parts = [counts & (folds == fold) for fold in np.unique(folds[counts])]
    if len(parts) < 2:
        return
    for variable, name in VARIABLES.items():
        values = getattr(residual.x, name)[:, j]
        low = sorted(values[rows].min() for rows in parts)[1]
        high = sorted(values[rows].max() for rows in parts)[-2]
        if not low < high:
            continue
        even = np.linspace(low, high, KNOTS // 2)
        columns = hats(np.clip(values, low, high), KNOTS - len(even), even)
        if columns.shape[1]:
            where = np.digitize(values, even)
            seen = np.sum([np.isin(where, where[rows]) for rows in parts], axis=0)
            yield (_function(variable, columns, torque, j),
                   (values >= low) & (values <= high) & (seen > 1))


def _function(variable, columns, torque, j):
    scale = np.full(columns.shape[1], 0.1 * torque[j])
    return Hypothesis(UNKNOWN, j, {j: columns * scale}, scale, {}, variable)


def hats(values, knots, more=()):
    """
    Return (N, k) piecewise linear functions of values (N,): none (N, 0) if fewer than four.

    Their corners are so many quantiles (knots), and `more`.
    """
    places = np.quantile(values, np.linspace(0.01, 0.99, knots))
    places = np.unique(np.concatenate((places, more)))
    # What a filter forgets comes to rest at 1e-300: no function has a slope for that.
    places = places[np.diff(places, prepend=-np.inf) > LEAST_APART * np.ptp(places)]
    if len(places) < 4:
        return np.zeros((len(values), 0))
    return np.stack([np.interp(values, places, row) for row in np.eye(len(places))], axis=1)
