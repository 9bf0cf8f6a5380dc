"""Ripple of motor and gear."""

import numpy as np

from ..motion import BANDWIDTH
from .effect import Effect, Shape


def _columns(x, j, shape):
    q, v = x.q[:, j], x.v[:, j]
    return np.stack([wave for k in (1.0, 2.0) for wave in waves(q, v, k * shape['periods'])],
                    axis=-1)


def waves(q, v, periods):
    """
    Return sin(periods q) and cos(periods q) as they come through the motion filter.

    q [rad], v [rad/s] filtered, of any one shape. A ripple is met at the frequency periods v,
    where the three-stage filter has gain (1 + i s)^-3 with s = periods v / w; the filtered
    position lags by 3 / w, so -3 s of its phase is there already.
    """
    s = periods * v / BANDWIDTH
    squared = s * s
    scale = (1.0 + squared) ** -3
    real, imaginary = scale * (1.0 - 3.0 * squared), scale * s * (squared - 3.0)
    angle = periods * q + 3.0 * s
    sine, cosine = np.sin(angle), np.cos(angle)
    return real * sine + imaginary * cosine, real * cosine - imaginary * sine


def _derived(values, _):
    first, second = np.hypot(*values[:2]), np.hypot(*values[2:])
    return {'amplitude': (first, 'Nm'), 'second_amplitude': (second, 'Nm')}


TORQUE_RIPPLE = Effect(
    'torque_ripple', 'motor and gear, or what a gear does to the torque sensor behind it: '
    'periodic in joint position, many periods per turn, with its second harmonic',
    'Holtz and Springob 1996',
    (('sine', 'Nm'), ('cosine', 'Nm'), ('second_sine', 'Nm'), ('second_cosine', 'Nm')),
    (0.03,) * 4, _columns, (Shape('periods', '1/turn', 60.0, ()),), in_link_torque=True,
    against='position within a period', derived=_derived)
