"""
What the no-load torque difference may be a function of: a joint's motion and heat (E2.1, E3.1).

Learning and the estimator call the same function, so both see the same numbers.
"""

import numpy as np

from ..errors import ConfigurationError

# Friction bends within this speed [rad/s] of standing still and is smooth beyond it; an inverse
# hyperbolic sine of the velocity makes both equally long, as a stationary kernel wants them.
BEND_SPEED = 0.05
POSITION, ACCELERATION, WARMTH = 1.0, 2.0, 10.0     # one unit: [rad], [rad/s^2], [K]

INPUTS = ('position', 'velocity', 'acceleration', 'temperature', 'pose')
DEFAULT_INPUTS = ('velocity', 'temperature')


def parse_inputs(text):
    """Return the input names of `a,b,...`; ConfigurationError for others, none or doubles."""
    names = tuple(text.split(','))
    if not set(names) <= set(INPUTS) or len(set(names)) < len(names):
        raise ConfigurationError('--inputs', 'is not usable', text,
                                 f'one or more of {", ".join(INPUTS)}, each once')
    return names


def input_width(names, n):
    """Return how many numbers the named inputs of each of n joints are."""
    return sum(n if name == 'pose' else 1 for name in names)


def difference_inputs(names, q, v, a, warmth):
    """
    Return (..., n, D) inputs of joints at q, v, a [rad, s] and warmth [K], all (..., n).

    Each joint has its own, and with `pose` the positions of all joints: what wrong link data
    leave depends on these.
    """
    columns = {'position': lambda: q[..., None] / POSITION,
               'velocity': lambda: np.arcsinh(v / BEND_SPEED)[..., None],
               'acceleration': lambda: a[..., None] / ACCELERATION,
               'temperature': lambda: warmth[..., None] / WARMTH,
               'pose': lambda: np.broadcast_to(q[..., None, :] / POSITION,
                                               (*q.shape, q.shape[-1]))}
    return np.concatenate([columns[name]() for name in names], axis=-1)
