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

    def load_regressor(self, q, v, a):
        """Return K (n, 10): torque of a load = K @ its products."""


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
        mean, std = self._belief.torque(self._model.load_regressor(q, v, a))
        std = np.hypot(std, self._friction * v)
        torque = self._model.torque(q, v, a, self._temperature) + mean
        return float(np.max((np.abs(torque) + self._sigma * std) / self._allowed))

    def worst(self, q, v, a):
        """Return the largest share over the points (m, n)."""
        return max((self.at(*point) for point in zip(q, v, a)), default=0.0)
