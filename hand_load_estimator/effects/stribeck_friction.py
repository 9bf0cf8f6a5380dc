"""Friction that falls from breakaway to Coulomb."""

import numpy as np

from .effect import Effect, Shape
from .smooth_sign import sign_of


def _columns(x, j, shape):
    v = x.v[:, j]
    bump = sign_of(v) * np.exp(-np.abs(v) / shape['stribeck_velocity'])
    return np.stack([bump, bump * x.warmth[:, j]], axis=-1)


STRIBECK_FRICTION = Effect(
    'stribeck_friction', 'falls from breakaway to Coulomb as lubrication builds up',
    'Bittencourt and Axelsson 2014', (('level', 'Nm'), ('slope', 'Nm/K')), (0.05, 1e-3), _columns,
    (Shape('stribeck_velocity', 'rad/s', 0.1, (0.03, 0.06, 0.12, 0.25, 0.5)),), default=True,
    positive=(0,))
