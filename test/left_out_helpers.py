"""Systems of made-up recordings, with noise of a known density."""

from dataclasses import replace

from core_helpers import effect_uses, four_axes, true_parameters
from effect_helpers import waves
import numpy as np

from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.identification.regression_system import System

JOINTS, DT = 4, 0.02
DENSITY = np.array([0.04, 0.02, 0.01, 0.01])


def system_of(runs=4, seconds=60.0, moving=None):
    """
    Return the System of recordings whose parameters are true_parameters.

    moving: per run the joints (n,) that move, or None for all.
    """
    robot, rng = four_axes(), np.random.default_rng(7)
    uses, evidence = effect_uses(robot), []
    for k in range(runs):
        motion = waves(robot, rng, seconds, 25.0)
        if moving is not None:
            # Others stand where they began.
            motion = replace(motion, q=np.where(moving[k], motion.q, motion.q[0]),
                             v=motion.v * moving[k], a=motion.a * moving[k])
        evidence.append(Evidence(f'run {k}', motion, np.zeros_like(motion.q)))
    return System(robot, uses, evidence, parameters(robot))


def parameters(robot):
    """Return the true parameters (P,)."""
    return true_parameters(robot, effect_uses(robot))


def noise(system, factor=1.0, seed=11):
    """Return a residual (N, n) with `factor` times the variance that DENSITY states."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=system.torque.shape) * np.sqrt(factor * DENSITY / DT)
