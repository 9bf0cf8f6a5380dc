"""What identification leaves: its density, its size in sliding, and the usual drift."""

import numpy as np

from ..torque.sliding import sliding_rms, surely_slides
from ..torque_model import WARMED
from .block_means import all_blocks

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
    memory, less when it is shorter; the largest product over block_means.LENGTHS is the safe one.
    """
    best = np.zeros(residual.shape[1])
    for blocks in all_blocks(weights, owner, dt):
        best = np.maximum(best, blocks.average(blocks.means(residual) ** 2) * blocks.length)
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


def sliding_left(system, left_out):
    """Return the residual (n,) [Nm] of a System's LeftOut while joints slide, as of Residuals."""
    sliding = surely_slides(system.velocity, system.z, system.doubt) & system.tells
    return sliding_rms(left_out.residual, sliding, system.dt, system.owner)


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
