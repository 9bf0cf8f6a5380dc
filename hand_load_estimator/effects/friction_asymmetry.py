"""Friction that differs between the directions."""

import numpy as np

from .effect import Effect, side_by_side


def _columns(x, j, _):
    # The levels belong to the directions the contacts are bent in: where they are not bent, on
    # the way between the levels, nothing is left of the difference. Only that tells it from an
    # offset.
    return side_by_side(np.abs(x.z[:, j]), np.abs(x.v[:, j]))


FRICTION_ASYMMETRY = Effect(
    'friction_asymmetry', 'friction differs between the directions: its level, its '
    'growth with speed',
    'Armstrong-Helouvry et al. 1994', (('level', 'Nm'), ('coefficient', 'Nm s/rad')), (0.01, 0.01),
    _columns, default=True)
