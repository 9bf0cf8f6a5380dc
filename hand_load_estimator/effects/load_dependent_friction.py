"""Friction that grows with the torque of the gear."""

import numpy as np

from .effect import Effect


def _columns(x, j, _):
    # As all friction it turns over the presliding travel, not with the sign of the velocity.
    return (np.abs(x.gear[:, j]) * x.z[:, j])[..., None]


LOAD_DEPENDENT_FRICTION = Effect(
    'load_dependent_friction', 'tooth friction grows with the torque the gear carries',
    'Hamon et al. 2010', (('coefficient', '-'),), (0.1,), _columns, against='gear torque',
    needs=frozenset({'gear'}), absolute=True, positive=(0,))
