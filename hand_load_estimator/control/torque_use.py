"""How much of the allowed joint torque a motion uses, with the load's uncertainty added."""

from typing import Protocol

import numpy as np

from .model_doubt import unknown_warmth_std


class TorqueSource(Protocol):
    """What this room needs of a torque model, beside what model_doubt reads; n joints."""

    robot: object
    noise: np.ndarray

    def torque(self, q, v, a, temperature):
        """Return the torque (n,) [Nm] without load, friction and rotor included."""

    def load_while_sliding(self, q, v, a, temperature, products):
        """Return K (n, 10), torque (n,): a load of products (10,) adds K @ products + torque."""


class TorqueUse:
    """
    Share of the allowed torque used at a point of a motion (equation of motion, E8.1).

    model: TorqueSource; belief: LoadBelief; sigma: how many standard deviations of the load's
    torque are added on the side that needs more; temperature (n,) [degC], NaN where unknown: then
    the joint may be as cold or as warm, and its friction is as uncertain as the load.
    """

    def __init__(self, model, belief, sigma, temperature):
        limits = model.robot.limits
        self._model, self._belief, self._sigma = model, belief, sigma
        self._temperature = temperature
        self._friction = unknown_warmth_std(model, temperature)
        self._allowed = limits.allowed_torque * limits.torque

    def at(self, q, v, a):
        """Return the largest share over the joints: 1 is the limit."""
        regressor, beside = self._model.load_while_sliding(q, v, a, self._temperature,
                                                           self._belief.mean)
        mean, std = self._belief.torque(regressor)
        std = np.hypot(std, self._friction * v)
        torque = self._model.torque(q, v, a, self._temperature) + mean + beside
        return float(np.max((np.abs(torque) + self._sigma * std) / self._allowed))

    def worst(self, q, v, a):
        """Return the largest share over the points (m, n)."""
        return max((self.at(*point) for point in zip(q, v, a)), default=0.0)
