"""
What friction held before a case's motion, and how long its torques tell of it.

A joint at rest holds whatever its last motion left in the contacts, anywhere between both levels
it slides at, and no torque at rest tells that from the load's. Over the first one or two
milliradians of travel it is forgotten. This is the truth about the plant, for a bound: no
estimator has it.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..plant import follow_motion, JointEvent
from ..plant.remembering_plant import RememberingPlant
from .cases import case_arguments, case_motion, CaseRun, hidden_effects, stream_samples


@dataclass(frozen=True)
class FrictionStart:
    """
    Friction's start in a CaseRun of N samples, n joints.

    std (n,) [Nm]: of the friction torque at the start, as plants draw it; left (N, n) [-]: what
    one Nm of it still is in the torque of each sample.
    """

    std: np.ndarray
    left: np.ndarray


def case_run_and_start(robot, case):
    """Return the CaseRun of a Case, the same as case_run's, and its FrictionStart."""
    motion = case_motion(robot, case)
    plant = RememberingPlant(robot, start_position=np.array(motion.position[0], dtype=float),
                             effects=hidden_effects(robot, case), **case_arguments(case))
    events, shares = [], []
    for event in follow_motion(plant, motion.time, motion.position, motion.velocity,
                               motion.acceleration):
        events.append(event)
        if isinstance(event, JointEvent):
            shares.append(replace(event, effort=plant.start_left()))
    run = CaseRun.of(robot, events)
    # In the effort's place it passes the same filter as the torques it is part of.
    left = np.array([sample.effort for sample in stream_samples(robot, shares)])
    return run, FrictionStart(plant.start_std, left)
