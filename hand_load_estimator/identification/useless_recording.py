"""Recordings from which nothing is to be learned of an arm's torques, refused before the work."""

import numpy as np

from ..errors import RecordingError
from ..stream.rejected_input import share_rejected, told_of_rejected
from ..torque.sliding import FEWEST_SECONDS, SLIDING_SPEED
from .clipped_effort import never_changes

# Share of the joint states rejected, and of a joint's efforts cut off, from which on the rest is
# no more than what happened to be left.
REJECTED, CUT_OFF = 0.5, 0.95


def refuse_useless(robot, evidence):
    """Raise RecordingError where an Evidence is of a recording that tells nothing of torques."""
    if share_rejected(evidence) > REJECTED:
        raise RecordingError(f'{told_of_rejected(evidence)[0]}; a model needs most of them: '
                             'correct the driver, or give the robot file of this arm and of this '
                             'unit of effort')
    said = _dead(robot, evidence)
    if said:
        raise RecordingError(f'{evidence.name}: an effort tells nothing while its joint moves: '
                             f'{", ".join(said)}; it is dead or cut off: correct the driver and '
                             'record again; `hand_load check` tells more')


def _dead(robot, evidence):
    """Return words on each joint that moves while its effort tells nothing."""
    motion, cut_off = evidence.motion, 1.0 - evidence.tells.mean(axis=0)
    moves = motion.dt @ (np.abs(motion.v) > SLIDING_SPEED) >= FEWEST_SECONDS
    constant = never_changes(robot, motion.effort * robot.effort.torque_constants)
    unit = 'A' if robot.effort.kind == 'motor_current' else 'Nm'
    out = []
    for j in np.flatnonzero(moves):
        if constant[j]:
            out.append(f'{robot.joints[j]} stays at {motion.effort[0, j]:.4g} {unit}')
        elif cut_off[j] > CUT_OFF:
            out.append(f'{robot.joints[j]} stands at an end of its range in '
                       f'{100.0 * cut_off[j]:.0f} % of the samples')
    return out
