"""
Inputs of the network: motion, torque difference and temperature of each joint (E1.3, E3.1).

Joined by what the regression knows: the friction state, the running Bayesian posterior's
innovation and how much of it the load's uncertainty explains (E4.1: the regressor's domain), and
the posterior's standard deviations. All scaled by figures of the robot and the torque model in
use, so that one network serves any model of that arm. Training and the estimator call the same
function.
"""

import numpy as np

# The posterior behind the innovations is renewed every so many samples.
REFRESH = 5
PER_JOINT, SHARED = 15, 11
# What they are and how they are scaled, for the card: an artefact serves these and no others.
INPUTS = (
    'sin(q)', 'cos(q)', 'v / largest v', 'a / largest a', 'asinh(torque difference / rmse) / 3',
    'asinh(innovation / rmse) / 3', "asinh(std of the load's torque / rmse) / 3",
    "asinh(load's torque / rmse) / 3", 'warmth / 20 K', 'friction state z',
    'doubt of z, at most 1',
    'log(density / intensity) / 6, at most 2', 'asinh(v / 0.01 rad/s) / 3',
    'asinh(slow innovation / its std) / 3',
    'log(slow innovation squared over what is expected + 0.01) / 3, at most 2',
    'which joint: one of n', 'log(posterior std / prior std) / 5, at least -1.4: ten',
    'temperatures measured')
# Training ends after seconds; what grows surer for hours must not leave the range it saw.
LEAST_LOG_STD = -1.4
# What the model lacks shows in slow residuals: innovations averaged over SLOW [s], and their mean
# square over LONG [s] against what load and model explain.
SLOW, LONG = 0.3, 3.0


class SlowResidual:
    """
    Follow the slow part of innovations (..., n) and how it compares with what is expected.

    relative (..., n): slow innovation in expected standard deviations; excess (..., n): its mean
    square, 1 where the stated density holds.
    """

    def __init__(self, shape):
        self._slow, self.relative, self.excess = np.zeros(shape), np.zeros(shape), np.ones(shape)

    def update(self, innovation, variance, density, dt):
        """Take innovation [Nm], variance of the load's torque [Nm^2], density [Nm^2 s]."""
        self._slow = self._slow + min(dt / SLOW, 1.0) * (innovation - self._slow)
        expected = density / (2.0 * SLOW) + variance
        self.relative = self._slow / np.sqrt(expected)
        self.excess = self.excess + min(dt / LONG, 1.0) * (self.relative ** 2 - self.excess)
        return self.relative, self.excess


def squash(x):
    """Return asinh(x) / 3: linear for small x, logarithmic for large."""
    return np.arcsinh(x) / 3.0


def feature_count(n):
    """Return the number of inputs per joint for an arm of n joints."""
    return PER_JOINT + n + SHARED


def features(limits, model, motion, warmth, friction, difference, load, slow, relative_std):
    """
    Return (..., n, F) inputs.

    limits: JointLimits; model: rmse [Nm], intensity [Nm^2 s] of the torque model, (n,) each;
    motion: q, v, a; warmth [K], NaN where not measured; friction: z, doubt, density [Nm^2 s];
    difference [Nm]; load: innovation [Nm], variance of the load's torque [Nm^2] and the torque
    itself [Nm] as the running posterior has them; slow: what SlowResidual says; all (..., n).
    relative_std (..., 10): posterior
    over prior standard deviations.
    """
    (rmse, intensity), (q, v, a), (z, doubt, density) = model, motion, friction
    innovation, variance, torque = load
    n, measured = q.shape[-1], np.isfinite(warmth)
    out = np.empty(q.shape + (feature_count(n),))
    out[..., 0], out[..., 1] = np.sin(q), np.cos(q)
    out[..., 2], out[..., 3] = v / limits.velocity, a / limits.acceleration
    out[..., 4], out[..., 5], out[..., 6], out[..., 7] = (
        difference, innovation, np.sqrt(variance), torque)
    out[..., 4:8] /= rmse[:, None]
    out[..., 8], out[..., 9] = np.where(measured, warmth, 0.0) / 20.0, z
    out[..., 10], out[..., 11] = np.minimum(doubt, 1.0), density / intensity
    out[..., 12], out[..., 13] = v / 0.01, slow[0]
    out[..., 14] = slow[1] + 0.01
    for block in (out[..., 4:8], out[..., 12:14]):
        block[...] = squash(block)
    logarithms = out[..., 11:PER_JOINT:3]
    logarithms[...] = np.minimum(np.log(logarithms) / (6.0, 3.0), 2.0)
    out[..., PER_JOINT:PER_JOINT + n] = np.eye(n)
    out[..., PER_JOINT + n:-1] = np.maximum(
        np.log(relative_std) / 5.0, LEAST_LOG_STD)[..., None, :]
    out[..., -1] = measured.any(axis=-1, keepdims=True)
    return out
