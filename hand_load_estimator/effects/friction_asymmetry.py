"""Friction that differs between the directions."""

import numpy as np

from .effect import Effect
from .smooth_sign import sign_of


def _columns(x, j, _):
    v = x.v[:, j]
    return np.stack([sign_of(v) ** 2, np.abs(v)], axis=-1)


FRICTION_ASYMMETRY = Effect(
    'friction_asymmetry', 'friction differs between the directions: its level, its '
    'growth with speed',
    'Armstrong-Helouvry et al. 1994', (('level', 'Nm'), ('coefficient', 'Nm s/rad')), (0.01, 0.01),
    _columns, default=True)
