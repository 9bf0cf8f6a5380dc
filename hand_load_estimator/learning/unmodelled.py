"""
Priors for torque the model does not have, drawn per training sequence.

All sizes are in units of what identification measured (friction levels, residual noise), so the
same priors serve every robot. Nothing here knows the plant: the friction state turns as a
model's does (torque/presliding.py), with a travel, a starting value and a shape of its own, and
the rest are generic disturbances an identified model is known to miss.
"""

from dataclasses import dataclass

import numpy as np

from ..effects.own_travel import BOTH, PLASTIC
from ..effects.smooth_sign import sign_of
from ..effects.stribeck_curve import left
from ..torque.presliding import REST_SPEED, REST_TIME, Turning

# How far identified arms are off: their travel (of its logarithm), the way over which contacts
# yield [levels], and what of the friction level, on the way between two levels, no such curve has.
# Together they leave a few hundredths of the level there, as simulated development arms do.
TRAVEL, YIELDING, BESIDE = 0.1, 0.16, 0.03


@dataclass(frozen=True)
class FrictionTruth:
    """
    True friction of one sequence, (n,) each.

    coulomb, breakaway [Nm] (the part that fades with speed); turning [Nm]: what turns more than
    all of it does; viscous [Nm s/rad]; stribeck_velocity [rad/s] and stribeck_exponent [-];
    distance [rad] and plastic of presliding.Turning; beside: share of the level that is on the way
    between two levels, beside that; start: friction state at rest, beyond 1 where static friction
    exceeds sliding.
    """

    coulomb: np.ndarray
    breakaway: np.ndarray
    turning: np.ndarray
    viscous: np.ndarray
    stribeck_velocity: np.ndarray
    stribeck_exponent: np.ndarray
    distance: np.ndarray
    plastic: np.ndarray
    beside: np.ndarray
    start: np.ndarray


def draw_friction(rng, coulomb, breakaway, turning, viscous, peak, way):
    """
    Return a FrictionTruth around identified values (n,) each.

    peak: Stribeck velocity and exponent; way: travel [rad] and plastic (presliding.Turning).
    """
    n, (velocity, exponent), (distance, plastic) = len(coulomb), peak, way

    def near(value, spread):
        return value * np.exp(rng.normal(0.0, spread, n))

    # Coulomb and viscous levels are varied by the model's measured drift (sequences.py).
    return FrictionTruth(coulomb, near(breakaway, 0.15), near(turning, 0.1),
                         viscous, near(velocity, 0.2), exponent, near(distance, TRAVEL),
                         np.clip(rng.normal(plastic, YIELDING), PLASTIC.least, BOTH),
                         rng.normal(0.0, BESIDE, n), rng.uniform(-1.2, 1.2, n))


def friction_state(rng, q, v, dt, truth):
    """
    Return z (N, n): the friction state along q (N, n), let go a little whenever a joint rests.

    v (N, n) [rad/s]; dt [s] of a row. Once it rests the contacts relax towards a random
    value (creep, a brake, a drive's dither).
    """
    z, turning, levels = np.empty_like(q), Turning(truth.plastic), _levels(v, truth)
    levels = levels / _levels(np.zeros(q.shape[1]), truth)
    state, rested = truth.start.copy(), np.zeros(q.shape[1])
    for k in range(len(q)):
        if k:
            # What the contacts bear stays, when the level goes up or down.
            state = turning.turned(state * levels[k - 1] / levels[k], q[k] - q[k - 1],
                                   levels[k] * truth.distance)
        before, rested = rested, np.where(np.abs(v[k]) < REST_SPEED, rested + dt, 0.0)
        if np.any(came := (rested > REST_TIME) & (before <= REST_TIME)):
            relaxed = rng.uniform(-1.1, 1.1, len(state))
            keep = rng.uniform(0.0, 1.0, len(state))
            state = np.where(came, keep * state + (1.0 - keep) * relaxed, state)
        z[k] = state
    return z


def _levels(v, truth):
    """Return what friction slides at (N, n) [Nm], never nothing."""
    fade = left(v, 0.0, truth.stribeck_velocity, truth.stribeck_exponent)
    return np.maximum(truth.coulomb + np.maximum(truth.breakaway, 0.0) * fade, 1e-9)


def friction_torque(z, v, truth):
    """Return the true friction (N, n) [Nm] at the reference temperature."""
    turned = z + truth.beside * np.maximum(1.0 - z * z, 0.0)
    return turned * _levels(v, truth) + truth.viscous * v + truth.turning * (z - sign_of(v))


def smooth_curve(rng, x, scale):
    """Return a random smooth function of x (N,) with unit RMS over its prior and given scale."""
    w = rng.normal(0.0, 1.0 / scale, 6)
    phase, size = rng.uniform(0.0, 2.0 * np.pi, 6), rng.normal(size=6)
    return np.sqrt(2.0 / 6.0) * np.sum(size * np.cos(np.multiply.outer(x, w) + phase), axis=-1)


SEVERE = 0.1  # share of sequences in which undeclared effects stand out


def disturbances(rng, q, v, torque, slow, dt):
    """
    Return (N, n) [Nm]: effects nobody declared, each present in some sequences; and severity.

    Mostly they are what stays hidden below the measured residual; in a SEVERE share of sequences
    they stand out of it, because the next robot has one that its recordings did not show.
    torque (N, n): what the drives hold; slow (n,) [Nm]: RMS of the slow part of the measured
    residual; dt [s] of a row.
    """
    out = np.zeros_like(q)
    n = q.shape[1]
    severe = rng.random() < SEVERE
    sizes = (0.0, 1.2) if severe else (-1.5, -0.3)
    for j in range(n):
        def strength(j=j):
            return slow[j] * 10.0 ** rng.uniform(*sizes)

        if rng.random() < 0.7:  # friction has some shape over speed that no formula has
            out[:, j] += 0.3 * strength() * smooth_curve(
                rng, np.arcsinh(v[:, j] / 0.1), 1.5) * np.tanh(v[:, j] / 0.02)
        if rng.random() < 0.25:  # torque ripple of motor and gear
            out[:, j] += strength() * np.sin(
                rng.uniform(4.0, 120.0) * q[:, j] + rng.uniform(0.0, 2.0 * np.pi))
        if rng.random() < 0.2:  # cables, balancers: smooth in position
            out[:, j] += strength() * smooth_curve(rng, q[:, j], 1.0)
        if rng.random() < 0.2:  # friction that follows the gear's torque
            share = 0.002 * 10.0 ** rng.uniform(*sizes)
            out[:, j] += share * np.abs(torque[:, j]) * np.tanh(v[:, j] / 0.01)
    if rng.random() < 0.2:  # gain of the effort
        out += torque * rng.normal(0.0, 0.001 * 10.0 ** rng.uniform(*sizes), n)
    if rng.random() < 0.2:  # effort late against position
        late = 4e-4 * rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(*sizes)
        out += late * np.gradient(torque, dt, axis=0)
    return out, severe


def coloured_noise(rng, count, density, dt):
    """Return (count, n) [Nm]: slow noise of low-frequency density (n,) [Nm^2 s]."""
    n = len(density)
    memory = 10.0 ** rng.uniform(-1.0, 0.0, n)
    std = np.sqrt(density / (2.0 * memory))
    keep = np.exp(-dt / memory)
    kicks = rng.normal(size=(count, n)) * std * np.sqrt(1.0 - keep ** 2)
    out = np.empty((count, n))
    state = rng.normal(size=n) * std
    for k in range(count):
        state = keep * state + kicks[k]
        out[k] = state
    return out
