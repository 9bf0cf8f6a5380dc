"""Pictures of what is left where nothing was fitted: against what it follows, and in time."""

import numpy as np

from .diagnosis import Picture
from .pictures import axis_label, bins, FEWEST_BINS, means_of
from .tracing.plain_functions import VARIABLES

SECONDS = 10.0


def pictures_left(robot, residual, rest, j, variables):
    """
    Return Pictures of what is left of joint j, without a curve.

    rest (N, n) [Nm]; variables: what it follows: drawn against the first of them that is one of
    the joint's own motion, if any is, and in time where it is strongest.
    """
    own = next((name for name in variables if name in VARIABLES), None)
    against = own and _against(robot, residual, rest[:, j], j, own)
    course = _strongest(robot, residual, rest[:, j], j)
    return (against, course) if against else (course,)


def _against(robot, residual, rest, j, variable):
    """Return a Picture of rest (N,) against one variable, or None with too few samples."""
    values = getattr(residual.x, VARIABLES[variable])[:, j]
    rows = residual.moving[:, j] & (residual.weights[:, j] > 0.0)
    made = bins(values, rows, lambda few: means_of(values, rest, few))
    if len(made) < FEWEST_BINS:
        return None
    return _bare(robot, j, axis_label(variable), *np.array(made).T)


def _strongest(robot, residual, rest, j):
    """Return a Picture of the strongest seconds of rest (N,)."""
    time = np.cumsum(residual.dt)
    width = max(8, int(SECONDS / np.median(residual.dt)))
    energy = np.convolve(rest ** 2, np.ones(width), 'valid')
    first = int(np.argmax(energy)) if len(energy) else 0
    rows = slice(first, first + width)
    return _bare(robot, j, 'time [s]', time[rows] - time[rows][0], rest[rows],
                 np.zeros(len(rest[rows])))


def _bare(robot, j, label, x, mean, std):
    zero = np.zeros(len(x))
    return Picture(robot.joints[j], label, x, mean, std, zero, zero, zero)
