"""
Inputs of the network: motion, torque difference and temperature of each joint (E1.3, E3.1).

Joined by what the regression knows: the friction state, the running Bayesian posterior's
innovation (E4.1: a residual in the regressor's domain) and its standard deviations. All scaled
by figures of the robot and the torque model in use, so that one network serves any model of that
arm. Training and the estimator call the same function.
"""

import numpy as np

# The posterior behind the innovations is renewed every so many samples.
REFRESH = 5
PER_JOINT = 11


def squash(x):
    """Return asinh(x) / 3: linear for small x, logarithmic for large."""
    return np.arcsinh(x) / 3.0


def feature_count(n):
    """Return the number of inputs for an arm of n joints."""
    return PER_JOINT * n + 12


def features(limits, rmse, intensity, motion, difference, innovation, warmth, z, doubt, density,
             relative_std, dt):
    """
    Return (..., F) inputs.

    limits: JointLimits; rmse, intensity (n,) of the torque model; motion: q, v, a (..., n);
    difference, innovation (..., n) [Nm]; warmth (..., n) [K], NaN where not measured; z, doubt
    (..., n); density (..., n) [Nm^2 s]; relative_std (..., 10): posterior over prior standard
    deviations; dt (...) [s].
    """
    q, v, a = motion
    known = np.isfinite(warmth).any(axis=-1, keepdims=True)
    per_joint = [np.sin(q), np.cos(q), v / limits.velocity, a / limits.acceleration,
                 squash(difference / rmse), squash(innovation / rmse),
                 np.nan_to_num(warmth) / 20.0, z, np.minimum(doubt, 1.0),
                 np.minimum(np.log(density / intensity) / 6.0, 2.0), squash(v / 0.01)]
    return np.concatenate(
        per_joint + [np.log(relative_std) / 5.0, known, dt[..., None] / 0.02 - 1.0], axis=-1)
