"""Where a residual lives: what foretells it, of motion, temperature, time and other joints."""

import numpy as np

from ..diagnosis import Structure
from ..tracing.plain_functions import hats, VARIABLES
from .find import find_residual
from .foretelling import Foretelling
from .rest import rest_of

CONSTANT, DIRECTION, TEMPERATURE, TIME = 'constant', 'direction', 'temperature', 'time'
ORDER = (CONSTANT, 'position', 'velocity', DIRECTION, 'acceleration', 'gear torque', TEMPERATURE,
         TIME)
OWN_MOTION = {name: VARIABLES[name] for name in ORDER if name in VARIABLES}
# Knots of a function of one variable, and of one of several that are fitted together.
KNOTS, FEW_KNOTS = 16, 8
# A recording's time gets one knot for so many of its blocks: quicker is no change over time.
BLOCKS_PER_KNOT, MOST_KNOTS = 3, 12
# Shares count of the structure there was, or of this share of the variance where there was less.
LEAST = 0.2


def structures(model, better, residual, evidence, warmed):
    """
    Return (Structure before, Structure after) of two TorqueModels on the same rows.

    residual: of `model` on Evidence; warmed: indices of joints whose temperature changed.
    """
    rows = residual.weights > 0.0
    old = residual.residual
    new = old if better is model else find_residual(better, evidence, cut=False).residual
    # What the better model removes was no noise, quick as it may be.
    floor = rest_of(np.where(rows, new, np.nan), residual.dt, residual.messages,
                    residual.owner).noise
    noise = np.minimum.reduce([floor, *(np.sqrt(_square(residual, values))
                                        for values in (old, new))])
    whole = np.maximum(_square(residual, old) - noise ** 2, LEAST * _square(residual, old))
    before = _structure(model.robot, residual, old, warmed, (noise, whole))
    after = before if better is model else \
        _structure(model.robot, residual, new, warmed, (noise, whole))
    return before, after


def _square(residual, values):
    """Return the mean square (n,) [Nm^2] of values (N, n), NaN for a joint that never slides."""
    total = residual.weights.sum(axis=0)
    squares = (residual.weights * values ** 2).sum(axis=0)
    return np.where(total > 0.0, squares, np.nan) / np.maximum(total, 1e-300)


def _structure(robot, residual, values, warmed, against):
    n, (noise, whole) = robot.n, against
    square = _square(residual, values)
    cells = np.full((len(ORDER), n, 2), np.nan)
    pairs = np.full((n, n, 2), np.nan)
    for j in range(n):
        # A function is about as large as what there is to foretell.
        size = np.sqrt(square[j])
        for name, beside, columns in _functions(residual, j, j in warmed):
            cells[ORDER.index(name), j] = _tried(
                residual, values[:, j], j, size * beside).explained(size * columns)
        pairs[j] = _pairs(residual, values[:, j], j, size)
    cells, pairs = cells / whole[:, None], pairs / whole[:, None, None]
    return Structure(
        np.sqrt(square), noise, dict(zip(ORDER, cells[..., 0])),
        dict(zip(ORDER, cells[..., 1])),
        pairs[..., 0], pairs[..., 1])


def _tried(residual, values, j, beside):
    """Return the Foretelling of values (N,) at joint j."""
    return Foretelling(values, residual.weights[:, j], residual.dt, residual.starts, beside)


def _functions(residual, j, warmed):
    """Yield (variable, columns (N, l) beside it, its columns (N, k)), the size of 1."""
    x = residual.x
    one = np.ones((len(x.q), 1))
    yield CONSTANT, one[:, :0], one
    for name, attribute in OWN_MOTION.items():
        yield name, one, hats(getattr(x, attribute)[:, j], KNOTS)
    yield DIRECTION, one, x.z[:, j, None]
    # Both change friction, which is seen as torque along the motion and grows with speed.
    friction = np.stack([one[:, 0], x.z[:, j], _scaled(x.v[:, j])], axis=1)
    if warmed:
        warmth = _scaled(x.warmth[:, j] - x.warmth[:, j].mean())
        yield TEMPERATURE, friction, _products(np.stack([warmth, warmth ** 2], axis=1), friction)
    yield TIME, friction, _products(_times(residual), friction)


def _times(residual):
    """Return piecewise linear functions (N, k) of the time within each recording."""
    out = []
    for owner in np.unique(residual.owner):
        own = residual.owner == owner
        knots = int(np.clip(own[residual.starts].sum() // BLOCKS_PER_KNOT, 2, MOST_KNOTS))
        places = np.linspace(residual.time[own][0], residual.time[own][-1], knots)
        out += [own * np.interp(residual.time, places, row) for row in np.eye(knots)]
    return np.stack(out, axis=1)


def _pairs(residual, values, j, size):
    """Return (n, 2): what joint j's own motion foretells, and what each other's adds to it."""
    x, n = residual.x, residual.residual.shape[1]
    own = np.hstack([hats(getattr(x, name)[:, j], FEW_KNOTS) for name in OWN_MOTION.values()])
    alone = _tried(residual, values, j, size * np.ones((len(own), 1)))
    beside = _tried(residual, values, j, size * own)
    return [alone.explained(size * own) if i == j else
            beside.explained(size * _of_other(x, i, j)) for i in range(n)]


def _of_other(x, i, j):
    """Return functions (N, k) of the motion of joint i, alone and with joint j's position."""
    waves = [np.stack([np.sin(q), np.cos(q)], axis=1) for q in (x.q[:, i], x.q[:, j])]
    return np.hstack([*(hats(values[:, i], FEW_KNOTS) for values in (x.q, x.v, x.a)),
                      _products(*waves)])


def _products(first, second):
    """Return (N, k l): every column of (N, k) times every one of (N, l)."""
    return (first[:, :, None] * second[:, None, :]).reshape(len(first), -1)


def _scaled(values):
    return values / max(np.abs(values).max(), 1e-9)


def followed(robot, residual, rest, j):
    """
    Return (variable, share) of which rest (N,) [Nm] of joint j is most a function.

    Its own variables and the velocities of its neighbours; share of the mean square of rest.
    """
    x, whole = residual.x, float(_square(residual, rest[:, None])[j])
    size = np.sqrt(whole)
    trial = _tried(residual, rest, j, np.zeros((len(rest), 0)))
    variables = {name: getattr(x, attribute)[:, j] for name, attribute in OWN_MOTION.items()}
    variables |= {f'velocity of {robot.joints[i]}': x.v[:, i]
                  for i in (j - 1, j + 1) if 0 <= i < robot.n}
    shares = {name: trial.explained(size * hats(values, KNOTS))[0] / whole
              for name, values in variables.items()}
    best = max(shares, key=lambda name: np.nan_to_num(shares[name]))
    return best, shares[best]
