"""Stand-ins for effects nobody knows: plain functions fitted to the residual, marked as such."""

import numpy as np

from .effect import Effect, Shape

# Places of the corners, as shares of the reach: close enough for a narrow peak, and closer where
# friction turns.
_TO_ONE_SIDE = np.array([0.01, *np.linspace(0.05, 1.0, 20)])
_PLACES = np.concatenate([-_TO_ONE_SIDE[::-1], _TO_ONE_SIDE])


def _hats(values, reach):
    """Return (N, m, 42) piecewise linear functions of values (N, m), flat beyond reach (m,)."""
    share = np.clip(values / reach, -1.0, 1.0)
    return np.stack([np.interp(share, _PLACES, row) for row in np.eye(len(_PLACES))], axis=-1)


def _of_velocity(x, j, shape):
    return _hats(x.v[:, j], shape['reach'])


def _of_position(x, j, shape):
    return _hats(x.q[:, j], shape['reach'])


_LEVELS = tuple((f'at_{place:+.2f}_of_reach', 'Nm') for place in _PLACES)
_STD = (0.05,) * len(_PLACES)

LEARNED_VELOCITY_CORRECTION = Effect(
    'learned_velocity_correction', 'no physics: a piecewise linear function of velocity in place '
    'of an unknown effect', 'fitted to the residual', _LEVELS, _STD, _of_velocity,
    (Shape('reach', 'rad/s', 1.0, ()),), learned=True)
LEARNED_POSITION_CORRECTION = Effect(
    'learned_position_correction', 'no physics: a piecewise linear function of position in place '
    'of an unknown effect', 'fitted to the residual', _LEVELS, _STD, _of_position,
    (Shape('reach', 'rad', 3.0, ()),), in_link_torque=True, against='position', learned=True)
