"""Pictures of effects: the residual that an effect explains against the variable it follows."""

import numpy as np

from ..effects import EFFECTS
from .diagnosis import UNKNOWN, Picture
from .tracing.plain_functions import VARIABLES

BINS, FEWEST, FEWEST_BINS = 24, 15, 4
# Effects of friction are drawn as torque along the motion: both directions would cancel.
_LOAD = 'size of gear torque'
_ALONG = ('temperature', _LOAD)
_UNITS = {'velocity': 'rad/s', 'position': 'rad', 'acceleration': 'rad/s^2', 'gear torque': 'Nm',
          'drive torque': 'Nm', 'rate of torque': 'Nm/s', 'drive torque times warmth': 'Nm K'}
# A dip at reversals is drawn over so many travels, more where few samples are in them, and nearer
# than so much of one the joint is at rest.
_TRAVELS, _RESTS = 4.0, 0.05


def picture(robot, residual, partial, hypothesis, score, joint):
    """
    Return the Picture of a Hypothesis with its Score on one joint, or None with too few samples.

    partial (N,) [Nm]: residual of the joint with all but the effect taken away.
    """
    against = _against(hypothesis)
    values, label = _variable(robot, residual, hypothesis, joint, against)
    columns = hypothesis.columns[joint]
    curve = columns @ score.theta
    if against in _ALONG:
        sign = np.sign(residual.x.v[:, joint])
        partial, curve, columns = partial * sign, curve * sign, columns * sign[:, None]
    if against == 'travel since reversal':
        rows = _near_reversals(values, hypothesis.shape['presliding_distance'])
    else:
        rows = residual.moving[:, joint] | (against == 'time')
    made = bins(values, rows, lambda own: _bin(values, partial, curve, columns, score, own))
    if len(made) < FEWEST_BINS:
        return None
    x, mean, error, middle, spread = (np.array(column) for column in zip(*made))
    return Picture(robot.joints[joint], label, x, mean, error, middle, middle - 1.96 * spread,
                   middle + 1.96 * spread)


def bins(values, rows, of):
    """Return [of(rows of a bin)] for bins of as many samples each, without what is None."""
    edges = np.unique(np.quantile(values[rows], np.linspace(0.0, 1.0, BINS + 1))) \
        if rows.sum() > FEWEST * 4 else np.zeros(0)
    made = [of(rows & (values >= a) & (values <= b)) for a, b in zip(edges[:-1], edges[1:])]
    return [row for row in made if row is not None]


def means_of(values, partial, rows):
    """Return the means of values and partial and the latter's standard error; None of few."""
    count = int(rows.sum())
    if count < FEWEST:
        return None
    # Neighbouring samples share their noise: a fifth of them counts.
    error = partial[rows].std() / np.sqrt(max(count / 5.0, 1.0))
    return values[rows].mean(), partial[rows].mean(), error


def _bin(values, partial, curve, columns, score, rows):
    means = means_of(values, partial, rows)
    if means is None:
        return None
    average = columns[rows].mean(axis=0)
    spread = np.sqrt(max(average @ score.covariance @ average, 0.0))
    return *means, curve[rows].mean(), spread


def _near_reversals(values, distance):
    """Return the rows (N,) bool within a few distances that are enough for a picture."""
    gone, reach = np.abs(values), _TRAVELS * distance
    # A joint at rest would crowd at zero.
    moved = gone > _RESTS * distance
    while (moved & (gone <= reach)).sum() < BINS * FEWEST and reach < gone.max():
        reach *= 2.0
    return moved & (gone <= reach)


def _against(hypothesis):
    if hypothesis.name == UNKNOWN:
        return hypothesis.variable
    if hypothesis.name == 'link_inertia':
        return 'position'
    if hypothesis.name == 'load_dependent_friction':
        return _LOAD
    return EFFECTS[hypothesis.name].against


def _variable(robot, residual, hypothesis, j, against):
    x = residual.x
    if against == 'temperature':
        knee = robot.reference_temperature + hypothesis.shape.get('knee', np.inf)
        level = f', levels off at {knee:.1f}' if np.isfinite(knee) else ''
        return x.warmth[:, j] + robot.reference_temperature, \
            f'joint temperature [degC]{level}\n(torque along the motion)'
    if against == 'position within a period':
        periods = hypothesis.shape['periods']
        return np.mod(periods * x.q[:, j], 2.0 * np.pi), \
            f'phase of the ripple, {periods:.1f} per turn [rad]'
    if against == _LOAD:
        return np.abs(x.gear[:, j]), f'{_LOAD} [Nm]\n(torque along the motion)'
    if against == 'travel since reversal':
        return travel(x.q[:, j]), 'travel since reversal [rad]'
    if against == 'time':
        return residual.time - residual.time.min(), 'time [s]'
    if against == 'drive torque times warmth':
        return x.drive[:, j] * x.warmth[:, j], axis_label(against)
    name = {'rate of torque': 'rate', **VARIABLES}[against]
    return getattr(x, name)[:, j], axis_label(against)


def axis_label(variable):
    """Return a variable with its unit."""
    return f'{variable} [{_UNITS[variable]}]'


def travel(q):
    """Return the signed distance (N,) [rad] travelled since the last reversal of q (N,)."""
    out = np.zeros(len(q))
    for k in range(1, len(q)):
        step = q[k] - q[k - 1]
        same = step * out[k - 1] >= 0.0
        out[k] = out[k - 1] + step if same else step
    return out
