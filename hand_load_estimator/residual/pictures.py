"""Pictures of effects: the residual that an effect explains against the variable it follows."""

import numpy as np

from ..effects import EFFECTS
from .diagnosis import UNKNOWN, Picture

BINS, FEWEST = 24, 15
# Effects of friction are drawn as torque along the motion: both directions would cancel.
_LOAD = 'size of gear torque'
_ALONG = ('temperature', _LOAD)
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
    edges = np.unique(np.quantile(values[rows], np.linspace(0.0, 1.0, BINS + 1))) \
        if rows.sum() > FEWEST * 4 else np.zeros(0)
    made = [_bin(values, partial, curve, columns, score, rows & (values >= a) & (values <= b))
            for a, b in zip(edges[:-1], edges[1:])]
    made = [row for row in made if row is not None]
    if len(made) < 4:
        return None
    x, mean, error, middle, spread = (np.array(column) for column in zip(*made))
    return Picture(robot.joints[joint], label, x, mean, error, middle, middle - 1.96 * spread,
                   middle + 1.96 * spread)


def _bin(values, partial, curve, columns, score, rows):
    count = int(rows.sum())
    if count < FEWEST:
        return None
    average = columns[rows].mean(axis=0)
    # Neighbouring samples share their noise: a fifth of them counts.
    error = partial[rows].std() / np.sqrt(max(count / 5.0, 1.0))
    return (values[rows].mean(), partial[rows].mean(), error, curve[rows].mean(),
            np.sqrt(max(average @ score.covariance @ average, 0.0)))


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
    values, unit = {'velocity': (x.v, 'rad/s'), 'position': (x.q, 'rad'),
                    'acceleration': (x.a, 'rad/s^2'), 'gear torque': (x.gear, 'Nm'),
                    'drive torque': (x.drive, 'Nm'), 'rate of torque': (x.rate, 'Nm/s'),
                    'drive torque times warmth': (
                        None if x.drive is None else x.drive * x.warmth, 'Nm K')}[against]
    return values[:, j], f'{against} [{unit}]'


def travel(q):
    """Return the signed distance (N,) [rad] travelled since the last reversal of q (N,)."""
    out = np.zeros(len(q))
    for k in range(1, len(q)):
        step = q[k] - q[k - 1]
        same = step * out[k - 1] >= 0.0
        out[k] = out[k - 1] + step if same else step
    return out
