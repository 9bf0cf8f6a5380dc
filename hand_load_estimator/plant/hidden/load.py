"""A load that hangs on the hand for a while, and that no recording declares."""

from dataclasses import dataclass

import numpy as np

from ...load import LoadParameters
from .effect import HiddenEffect, Parameter

_RADIUS = 0.05  # [m] of the ball that is held
_OFF = 0.05     # [m] of its centre from the rated load's, along each axis


@dataclass(frozen=True)
class Held:
    """LoadParameters that the hand holds beside what it has, from start to end [s]."""

    load: LoadParameters
    start: float
    end: float


class LoadChange(HiddenEffect):
    """
    A ball that the hand takes at `start`, holds for `duration` [s] and lets go.

    A strength is stated while it is held, not over the whole motion.
    """

    name, amplitude = 'load_change', 'mass'
    parameters = {'mass': Parameter('kg', 0.0), 'com': Parameter('m', size=3),
                  'start': Parameter('s', 0.0), 'duration': Parameter('s', 0.0)}
    per_joint, shared = False, True

    def draw(self, rng, truth, motion):
        """Return a place near the rated load's, and four seconds from the sixth second on."""
        return {'com': motion.robot.rated_load.com + rng.uniform(-_OFF, _OFF, 3), 'start': 6.0,
                'duration': 4.0}

    def torque_along(self, motion, truth, p):
        """Return the torque of the ball held all along the motion."""
        products = _ball(p).to_products()
        return np.array([motion.robot.load_regressor(*row) @ products
                         for row in zip(motion.q, motion.v, motion.a)])

    def apply(self, truth, p):
        """Let the hand hold it for its time."""
        truth.held.append(Held(_ball(p), p['start'], p['start'] + p['duration']))


def _ball(p):
    return LoadParameters(p['mass'], p['com'], 0.4 * p['mass'] * _RADIUS ** 2 * np.eye(3))
