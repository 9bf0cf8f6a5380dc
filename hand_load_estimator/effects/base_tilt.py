"""A base that leans."""

import numpy as np

from .effect import Effect


def _columns(x, j, _):
    return x.tilt()[:, j]


def _derived(values, _):
    return {'angle': (float(np.linalg.norm(values)), 'rad')}


BASE_TILT = Effect(
    'base_tilt', 'gravity does not point where the robot file says: one rotation, for a '
    'level base about its x and y; the angles are one rotation vector',
    'first principles: a small rotation r turns gravity g to g + r x g',
    (('about_first_axis', 'rad'), ('about_second_axis', 'rad')), (0.03, 0.03),
    _columns, in_link_torque=True, against='position', whole_arm=True, absolute=True,
    derived=_derived, needs=frozenset({'tilt'}))
