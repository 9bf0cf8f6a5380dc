"""A constant beside the torque."""

import numpy as np

from .effect import Effect


def _columns(x, j, _):
    return np.ones_like(x.q[:, j])[..., None]


TORQUE_OFFSET = Effect(
    'torque_offset', 'constant: sensor zero, or unequal friction levels of the directions',
    'Swevers et al. 2007', (('level', 'Nm'),), (0.02,), _columns, in_link_torque=True,
    against='time', default=True)
