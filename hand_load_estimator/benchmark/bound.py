"""
The Cramer-Rao bound: what no unbiased estimator can beat on the same recording.

Torque noise known, torque model exact, friction state known: information is the sum of
K^T K / sigma^2 over all messages, joined by the same prior as everybody uses: where the messages
tell little (moments of inertia, the first tenths of a second) it is that prior's, which is 1.4 to
2 times as wide as the loads that are drawn, and whoever learned these goes below it. The second
bound takes the same messages where nobody knows what each joint's friction held before the motion:
that torque f, one per joint, is estimated along with the load m from rows K m + left f, where
`left` is the derivative of friction along the true motion, and then taken out of their joint
information (Schur complement). f is drawn evenly over what contacts can hold; only its variance
counts here, which an estimator that is no linear one might go below.
"""

import numpy as np

from ..estimators.information import message_covariance
from ..estimators.load_prior import load_prior
from ..load import products_jacobian_of_shape


def shape_of(load):
    """Return the shape vector (10,) of LoadParameters (load.py); a load of nothing has none."""
    shape = load.to_message().copy()
    shape[4:] = shape[4:] / max(load.mass, 1e-6)
    return shape


class Bound:
    """
    Accumulate information along a recording for a load that is known here.

    noise (n,) [Nm] of a message, of which `rate` [Hz] come; start_std (n,) [Nm]: standard
    deviation of the friction torque before the motion.
    """

    def __init__(self, robot, load, noise, rate, start_std):
        self._robot, self._shape = robot, shape_of(load)
        self._jacobian = products_jacobian_of_shape(self._shape)
        self._precision = rate / np.asarray(noise) ** 2
        self._prior = np.diag(load_prior(robot).std ** -2.0)
        # Of the load, of the starts, whose matrix is diagonal, and between them.
        self._information = np.zeros((10, 10))
        self._of_start = np.asarray(start_std, dtype=float) ** -2.0
        self._between = np.zeros((10, robot.n))

    def update(self, sample, left):
        """Add the messages behind a MotionSample; left (n,) [-]: their share of the start."""
        k = self._robot.load_regressor(sample.q, sample.v, sample.a)
        weighed = (k * (self._precision * sample.dt)[:, None]).T
        self._information += weighed @ k
        self._between += weighed * left
        self._of_start += self._precision * sample.dt * left ** 2

    def std(self):
        """Return standard deviations (10,) in message order, friction's state known."""
        return self._std_of(self._information)

    def std_start_unknown(self):
        """Return standard deviations (10,) in message order, friction's start unknown."""
        told = self._between / self._of_start @ self._between.T
        return self._std_of(self._information - told)

    def _std_of(self, information):
        """Return std (10,) from the information (10, 10) about the inertial products."""
        information = self._jacobian.T @ information @ self._jacobian + self._prior
        covariance = np.linalg.inv(information)
        return np.sqrt(np.diag(message_covariance(self._shape, covariance)))
