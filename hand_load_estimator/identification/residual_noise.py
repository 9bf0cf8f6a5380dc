"""What identification leaves: its density, its size in sliding, its drift between recordings."""

import numpy as np

from ..torque_model import WARMED

# Lengths [s] of the block means from which the residual's density is read.
BLOCK_MEANS = (0.06, 0.2, 0.5, 1.0)
# Smallest residual believed, as a fraction of the joint's maximum torque.
LEAST_NOISE = 1e-4
# Shares by which offset, Coulomb level and viscous coefficient of one day differ from another's
# [standard deviations] where no temperature is known: viscous friction falls by a third to a half
# from a cold joint to a warm one, Coulomb's changes little (Bittencourt et al. 2010).
USUAL_DRIFT = np.array([0.0, 0.05, 0.2])


def density(residual, weights, owner, dt):
    """
    Return the residual's low-frequency density (n,) [Nm^2 s] from means over blocks.

    A block's mean has variance density / length when the block is longer than the residual's
    memory, less when it is shorter; the largest product over BLOCK_MEANS is the safe one.
    """
    period = float(np.median(dt))
    best = np.zeros(residual.shape[1])
    for length in BLOCK_MEANS:
        size = max(1, round(length / period))
        count = len(residual) // size
        if count < 8:
            break
        shape = (count, size, residual.shape[1])
        r, w = residual[:count * size].reshape(shape), weights[:count * size].reshape(shape)
        block_owner = owner[:count * size].reshape(count, size)
        whole = (block_owner == block_owner[:, :1]).all(axis=1)
        total = w.sum(axis=1)
        means = (w * r).sum(axis=1) / np.maximum(total, 1e-30)
        good = total * whole[:, None]
        best = np.maximum(best, (good * means ** 2).sum(axis=0)
                          / np.maximum(good.sum(axis=0), 1e-30) * size * period)
    return best


def rmse_of(model, system, residual, moved):
    """
    Return the RMS (n,) [Nm] of a residual (N, n) of a System while joints surely slide.

    Joints that are not among `moved` (n,) show how they stand only; they may leave as much more
    as a TorqueModel identified from the System does not know of their friction.
    """
    slides = (system.doubt < 0.1) & (np.abs(system.z) > 0.9)
    shown = np.where(moved, slides, True) & system.tells
    rmse = np.sqrt((shown * residual ** 2).sum(axis=0) / np.maximum(shown.sum(axis=0), 1))
    unknown = np.where(moved, 0.0, model.friction_doubt())
    return np.maximum(np.hypot(rmse, unknown), LEAST_NOISE * model.robot.limits.torque)


def drift_of(system, residual, weights):
    """
    Return the std (n, 3) between recordings of offset, Coulomb level and viscous coefficient.

    Each recording's residual is fitted by the three; the spread over recordings, less what its
    own noise explains, is what changes from day to day. Recordings are halved, so that one alone
    also shows how it changes with time.
    """
    n = residual.shape[1]
    out = np.zeros((n, 3))
    groups = []
    for k in np.unique(system.recording):
        rows = np.flatnonzero(system.recording == k)
        groups += [half for half in np.array_split(rows, 2) if len(half) > 50]
    for j in range(n):
        fits, errors = [], []
        for rows in groups:
            moving = rows[np.abs(system.velocity[rows, j]) > 0.02]
            if len(moving) < 50:
                continue
            y = np.stack([np.ones(len(moving)),
                          *(values[moving, j] for values in system.drifting)], axis=1)
            w = weights[moving, j]
            covariance = np.linalg.inv((y * w[:, None]).T @ y + 1e-9 * np.eye(3))
            fits.append(covariance @ ((y * w[:, None]).T @ residual[moving, j]))
            errors.append(np.diag(covariance))
        if fits:
            # Moment estimate of a random effect around zero, each fit weighed by its precision;
            # a quarter of the fits' own error stays as what this many fits cannot exclude.
            precision = 1.0 / np.array(errors)
            total = precision.sum(axis=0)
            excess = ((np.square(fits) * precision).sum(axis=0) - len(fits)) / total
            out[j] = np.sqrt(np.maximum(excess, 0.25 * len(fits) / total))
    return out


def known_joints(evidence):
    """Tell of which joints (n,) a list of Evidence knows the temperature most of the time."""
    return np.isfinite(np.concatenate([e.motion.temperature for e in evidence])).mean(axis=0) > 0.5


def with_usual_drift(model, system, drift, told):
    """
    Return the drift (n, 3) that a model is to state of which a System shows so much.

    model: a TorqueModel identified from the System; told (n,): joints whose temperature is known.
    Few recordings show little of how friction differs from day to day: where no effect of a known
    temperature tells that, USUAL_DRIFT counts as one of them. Nothing less than seen is stated.
    """
    recordings = len(np.unique(system.recording))
    figures = np.stack([np.zeros(model.robot.n), model.friction_level(),
                        model.viscous_friction()], axis=1)
    mixed = np.sqrt(((recordings - 1) * drift ** 2 + (USUAL_DRIFT * figures) ** 2) / recordings)
    for use in model.uses:
        if use.name in WARMED and told[use.joint]:
            mixed[use.joint, WARMED[use.name]] = 0.0
    return np.maximum(drift, mixed)
