"""Viscous friction that grows less than in proportion to velocity."""

import numpy as np

from .effect import Effect, Shape, SLOWEST

# [rad/s] What thins at such speeds only is plain viscous friction at those of an arm.
FASTEST = 10.0


def _columns(x, j, shape):
    share = x.v[:, j] / shape['thinning_velocity']
    return (share / (1.0 + np.abs(share) ** shape['exponent']))[..., None]


# Cross's fluid between two walls: viscosity halves at the velocity. With an exponent of one the
# torque levels off there, with less it goes on growing with the power that is left of one.
SHEAR_THINNING_FRICTION = Effect(
    'shear_thinning_friction', 'grows less than velocity, as a lubricant that thins under shear',
    'Cross 1965; Waiboer et al. 2005', (('level', 'Nm'),), (0.1,), _columns,
    (Shape('thinning_velocity', 'rad/s', 0.5, (0.05, 0.1, 0.2, 0.4, 0.8, 1.6),
           least=SLOWEST, most=FASTEST),
     Shape('exponent', '-', 1.0, (1.0,), 25.0)), positive=(0,))
