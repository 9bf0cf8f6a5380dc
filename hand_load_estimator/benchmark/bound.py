"""
The Cramer-Rao bound: what no unbiased estimator can beat on the same recording.

Torque noise known, torque model exact, friction state known: information is the sum of
K^T K / sigma^2 over all messages, joined by the same prior as everybody uses.
"""

import numpy as np

from ..estimators.information import message_covariance
from ..estimators.load_prior import load_prior
from ..load import products_jacobian_of_shape


class Bound:
    """Accumulate information along a recording for a load that is known here."""

    def __init__(self, robot, load, noise, rate):
        shape = load.to_message().copy()
        shape[4:] = shape[4:] / max(load.mass, 1e-6)
        self._robot, self._shape = robot, shape
        self._jacobian = products_jacobian_of_shape(shape)
        self._precision = rate / np.asarray(noise) ** 2
        self._prior = np.diag(load_prior(robot).std ** -2.0)
        self._information = np.zeros((10, 10))

    def update(self, sample):
        """Add the messages behind a MotionSample."""
        k = self._robot.load_regressor(sample.q, sample.v, sample.a)
        self._information += (k * (self._precision * sample.dt)[:, None]).T @ k

    def std(self):
        """Return standard deviations (10,) in message order."""
        information = self._jacobian.T @ self._information @ self._jacobian + self._prior
        covariance = np.linalg.inv(information)
        return np.sqrt(np.diag(message_covariance(self._shape, covariance)))
