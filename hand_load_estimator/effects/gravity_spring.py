"""A balancer."""

import numpy as np

from .effect import Effect, amplitude_and_angle


def _columns(x, j, _):
    q = x.q[:, j]
    return np.stack([np.sin(q), np.cos(q)], axis=-1)


def _derived(values, _):
    stiffness, angle = amplitude_and_angle(*values)
    return {'stiffness': (stiffness, 'Nm'), 'angle': (angle, 'rad')}


GRAVITY_SPRING = Effect(
    'gravity_spring', 'balancer: k sin(q - q0), one period per turn', 'Herder 2001',
    (('sine', 'Nm'), ('cosine', 'Nm')), (0.05, 0.05), _columns, in_link_torque=True,
    against='position', derived=_derived, pulls=True)
