"""Stand-ins for effects nobody knows: plain functions fitted to the residual, marked as such."""

import numpy as np

from .effect import Effect, Shape

# Places of the corners, as shares of the reach: dense where friction turns.
_PLACES = np.array([-1.0, -0.75, -0.5, -0.3, -0.15, -0.03, 0.03, 0.15, 0.3, 0.5, 0.75, 1.0])


def _hats(values, reach):
    """Return (N, m, 12) piecewise linear functions of values (N, m), flat beyond reach (m,)."""
    share = np.clip(values / reach, -1.0, 1.0)
    return np.stack([np.interp(share, _PLACES, row) for row in np.eye(len(_PLACES))], axis=-1)


def _of_velocity(x, j, shape):
    return _hats(x.v[:, j], shape['reach'])


def _of_position(x, j, shape):
    return _hats(x.q[:, j], shape['reach'])


_LEVELS = tuple((f'at_{place:+.2f}_of_reach', 'Nm') for place in _PLACES)

LEARNED_VELOCITY_CORRECTION = Effect(
    'learned_velocity_correction', 'no physics: a piecewise linear function of velocity in place '
    'of an unknown effect', 'fitted to the residual', _LEVELS, (0.05,) * 12, _of_velocity,
    (Shape('reach', 'rad/s', 1.0, ()),), learned=True)
LEARNED_POSITION_CORRECTION = Effect(
    'learned_position_correction', 'no physics: a piecewise linear function of position in place '
    'of an unknown effect', 'fitted to the residual', _LEVELS, (0.05,) * 12, _of_position,
    (Shape('reach', 'rad', 3.0, ()),), in_link_torque=True, against='position', learned=True)
