"""Effects of the drive and its sensor: rotor inertia, offset."""

import numpy as np

from .effect import Effect


def _acceleration(x, j, _):
    return x.a[:, j][..., None]


def _constant(x, j, _):
    return np.ones_like(x.q[:, j])[..., None]


ROTOR = Effect(
    'rotor_inertia', 'torque in proportion to joint acceleration: the rotor behind the gear',
    'Swevers et al. 2007', (('inertia', 'kg m^2'),), (0.02,), _acceleration)
OFFSET = Effect(
    'torque_offset', 'constant: sensor zero, unequal friction levels of the directions',
    'Swevers et al. 2007', (('level', 'Nm'),), (0.02,), _constant, in_link_torque=True)
