"""
Find gravity in the base frame from effort, whatever gain each joint's effort has.

effort_j = g_j (inertial_j + G_j gravity) + friction_j, bilinear in the gains g and gravity, is
solved by turns from the robot file's direction and the six axes.
"""

from dataclasses import dataclass

import numpy as np

_TURNS = 60
# A fit whose energy is this fraction of the effort's own is as good as a real arm's gets.
_FLOOR = 1e-4


@dataclass(frozen=True)
class GravityFit:
    """
    vector (3,) [m/s^2] of the robot file's length; std of its direction [rad]; gains (k,).

    improvement: by what fraction the unexplained RMS is smaller than with the file's direction.
    """

    vector: np.ndarray
    std: float
    gains: np.ndarray
    improvement: float


def _moments(columns):
    """Return the (5, 5) second moments of effort, inertial, gravity, less friction and offset."""
    wanted = np.column_stack([columns.effort, columns.inertial, columns.gravity])
    basis, size, _ = np.linalg.svd(columns.nuisance, full_matrices=False)
    basis = basis[:, size > 1e-8 * size[0]]
    wanted = wanted - basis @ (basis.T @ wanted)
    return wanted.T @ wanted


def _gains(moments, gravity):
    direction = np.r_[0.0, 1.0, gravity]
    power = np.array([direction @ m @ direction for m in moments])
    cross = np.array([m[0] @ direction for m in moments])
    gains = cross / np.maximum(power, 1e-12)
    effort = np.array([m[0, 0] for m in moments])
    return gains, np.maximum(effort - gains * cross, _FLOOR * effort + 1e-12)


def _gravity(moments, gains, weights, norm):
    lhs = sum(w * g * g * m[2:, 2:] for m, g, w in zip(moments, gains, weights))
    rhs = sum(w * g * (m[2:, 0] - g * m[2:, 1]) for m, g, w in zip(moments, gains, weights))
    # A little stiffness keeps a direction without information at zero.
    gravity = np.linalg.solve(lhs + (1e-9 * np.trace(lhs) + 1e-12) * np.eye(3), rhs)
    return gravity * norm / max(np.linalg.norm(gravity), 1e-12)


def _by_turns(moments, counts, start):
    gravity, norm = np.array(start, dtype=float), np.linalg.norm(start)
    for _ in range(_TURNS):
        gains, energy = _gains(moments, gravity)
        gravity = _gravity(moments, gains, counts / energy, norm)
    gains, energy = _gains(moments, gravity)
    return float(counts @ np.log(energy)), gravity, gains, energy


def _direction_std(moments, gains, gravity, variances):
    """Return the std [rad] of the direction along its worst axis, gains left free."""
    k = len(gains)
    # The length of gravity is known: only its two directions across are free.
    across = np.linalg.svd(gravity[None])[2][1:].T
    information = np.zeros((k + 2, k + 2))
    for i, (m, g, variance) in enumerate(zip(moments, gains, variances)):
        jacobian = np.zeros((5, k + 2))
        jacobian[1, i], jacobian[2:, i] = 1.0, gravity
        jacobian[2:, k:] = g * across
        information += jacobian.T @ m @ jacobian / variance
    size = np.sqrt(np.diag(information))
    if np.any(size == 0.0):
        return np.inf
    scaled = information / np.outer(size, size)
    if np.linalg.cond(scaled) > 1e10:
        return np.inf
    covariance = np.linalg.inv(scaled)[k:, k:] / np.outer(size[k:], size[k:])
    return float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]) / np.linalg.norm(gravity))


def fit_gravity(columns, expected, spread):
    """
    Return the GravityFit of the JointColumns of moving joints.

    expected (3,): gravity of the robot file; spread: factor by which correlation in time widens
    a standard deviation. Where gravity is all the effort shows, the sign of the vector and of
    all gains can change together; the caller decides by the friction.
    """
    moments = [_moments(c) for c in columns]
    counts = np.array([len(c.effort) for c in columns], dtype=float)
    norm = np.linalg.norm(expected)
    starts = [expected, *(norm * np.vstack([np.eye(3), -np.eye(3)]))]
    misfit, gravity, gains, energy = min((_by_turns(moments, counts, s) for s in starts),
                                         key=lambda found: found[0])
    as_told = counts @ np.log(_gains(moments, np.array(expected))[1])
    std = spread * _direction_std(moments, gains, gravity, energy / counts)
    improvement = 1.0 - np.exp(0.5 * (misfit - as_told) / counts.sum())
    return GravityFit(gravity, std, gains, float(improvement))
