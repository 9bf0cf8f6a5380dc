"""Friction that falls from breakaway to Coulomb."""

import numpy as np

from .effect import Effect, Shape, side_by_side, SLOWEST
from .own_travel import of_own_travel, OWN_TRAVEL, PLASTIC
from .stribeck_curve import left

# How the peak falls, and how temperature moves it: only a large peak tells more than the plainest.
EXPONENT = Shape('exponent', '-', 1.0, (1.0,), 25.0)
VELOCITY_RANGE = Shape('velocity_range', 'K', np.inf, (np.inf,), 25.0)

# [rad/s] A peak that has not fallen at such speeds is none: it would be a level of friction.
FASTEST_PEAK = 1.0


def _columns(x, j, shape):
    peak = shape['stribeck_velocity'], shape[EXPONENT.name], shape[VELOCITY_RANGE.name]
    bump = of_own_travel(x, j, shape, x.z[:, j] * left(x.v[:, j], x.warmth[:, j], *peak), *peak)
    return side_by_side(bump, bump * x.warmth[:, j])


STRIBECK_FRICTION = Effect(
    'stribeck_friction', 'falls from breakaway to Coulomb as lubrication builds up',
    'Bittencourt and Axelsson 2014', (('level', 'Nm'), ('slope', 'Nm/K')), (0.05, 1e-3), _columns,
    (Shape('stribeck_velocity', 'rad/s', 0.1, (0.03, 0.06, 0.12, 0.25, 0.5),
           least=SLOWEST, most=FASTEST_PEAK), EXPONENT,
     VELOCITY_RANGE, OWN_TRAVEL, PLASTIC),
    default=True, positive=(0,), of_warmth=(1,))
