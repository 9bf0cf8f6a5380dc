"""Cables and hoses that pull."""

import numpy as np

from .effect import Effect


def _columns(x, j, _):
    # Half turns, so that the powers stay of one size over a joint's range.
    turn = x.q[:, j] / np.pi
    return np.stack([np.ones_like(turn), turn, turn ** 2, turn ** 3, turn ** 4], axis=-1)


CABLE_DRAG = Effect(
    'cable_drag', 'cables and hoses: a smooth, not periodic function of joint position',
    'first principles: what is smooth is its Taylor series, here to the fourth power', tuple(
        (name, 'Nm') for name in ('level', 'first', 'second', 'third', 'fourth')), (0.05,) * 5,
    _columns, in_link_torque=True,
    against='position', pulls=True)
