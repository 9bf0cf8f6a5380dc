"""Friction that falls from breakaway to Coulomb."""

import numpy as np

from .effect import Effect, Shape, side_by_side
from .own_travel import of_own_travel, OWN_TRAVEL


def _columns(x, j, shape):
    velocity = shape['stribeck_velocity']
    bump = of_own_travel(x, j, shape, x.sign[:, j] * np.exp(-np.abs(x.v[:, j]) / velocity),
                         velocity)
    return side_by_side(bump, bump * x.warmth[:, j])


STRIBECK_FRICTION = Effect(
    'stribeck_friction', 'falls from breakaway to Coulomb as lubrication builds up',
    'Bittencourt and Axelsson 2014', (('level', 'Nm'), ('slope', 'Nm/K')), (0.05, 1e-3), _columns,
    (Shape('stribeck_velocity', 'rad/s', 0.1, (0.03, 0.06, 0.12, 0.25, 0.5)), OWN_TRAVEL),
    default=True, positive=(0,))
