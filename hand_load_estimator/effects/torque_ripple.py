"""Ripple of motor and gear."""

import numpy as np

from ..motion import BANDWIDTH
from .effect import Effect, Shape


def _columns(x, j, shape):
    q, v = x.q[:, j], x.v[:, j]
    return np.stack([wave(q, v, k * shape['periods'], phase)
                     for k in (1.0, 2.0) for phase in (0.0, 0.5 * np.pi)], axis=-1)


def wave(q, v, periods, phase):
    """
    Return sin(periods q + phase) as it comes through the motion filter.

    q [rad], v [rad/s] filtered, of any one shape. A ripple is met at the frequency periods v,
    where the three-stage filter has gain (1 + s^2)^(-3/2) and phase -3 atan s with
    s = periods v / w; the filtered position lags by 3 / w, so -3 s of it is there already.
    """
    s = periods * v / BANDWIDTH
    return (1.0 + s * s) ** -1.5 * np.sin(periods * q + phase + 3.0 * (s - np.arctan(s)))


def _derived(values, _):
    first, second = np.hypot(*values[:2]), np.hypot(*values[2:])
    return {'amplitude': (first, 'Nm'), 'second_amplitude': (second, 'Nm')}


TORQUE_RIPPLE = Effect(
    'torque_ripple', 'motor and gear: periodic in joint position, many periods per turn, with its '
    'second harmonic', 'Holtz and Springob 1996',
    (('sine', 'Nm'), ('cosine', 'Nm'), ('second_sine', 'Nm'), ('second_cosine', 'Nm')),
    (0.03,) * 4, _columns, (Shape('periods', '1/turn', 60.0, ()),), in_link_torque=True,
    against='position within a period', derived=_derived)
