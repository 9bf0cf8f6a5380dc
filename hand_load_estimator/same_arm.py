"""Are two robot files of the same arm? Their URDFs tell by where each joint lies on its link."""

import numpy as np
import pinocchio as pin

# Factory calibrations of UR arms move joints by up to 1 mm and turn them by up to 0.007 rad. Arms
# with the same joint names lie 19 mm (UR3, UR3e) or more apart at some joint (UR10, UR10e: 24 mm).
SAME_PLACE, SAME_DIRECTION = 0.010, 0.1    # [m], [rad]


def arm_difference(one, other):
    """
    Return in words where two Robots with the same joint names differ most, '' for the same arm.

    The first joint's place is left out: it says where the arm stands.
    """
    apart = [(joint, *_joint_difference(one, other, j))
             for j, joint in enumerate(one.joints, start=1)]
    joint, distance, _ = max(apart, key=lambda found: found[1])
    if distance > SAME_PLACE:
        return f'{joint} lies {1e3 * distance:.0f} mm from where {other.name} has it'
    joint, _, angle = max(apart, key=lambda found: found[2])
    if angle > SAME_DIRECTION:
        return f'{joint} is turned by {angle:.2f} rad from where {other.name} has it'
    return ''


def _joint_difference(one, other, j):
    """Return distance [m] and angle [rad] between two arms' places of joint j on its link."""
    turn, offset = np.zeros(3), np.zeros(3)
    if j > 1:
        places = [robot.model.jointPlacements[j] for robot in (one, other)]
        offset = places[0].translation - places[1].translation
        turn = pin.log3(places[0].rotation.T @ places[1].rotation)
    axes = [_axis(robot, j) for robot in (one, other)]
    # A hinge and a slide have nothing in common: a quarter turn.
    between = np.arccos(np.clip(axes[0] @ axes[1], -1.0, 1.0))
    return np.linalg.norm(offset), max(np.linalg.norm(turn), between)


def _axis(robot, j):
    """Return the direction (6,) in which joint j moves, in its own frame, length 1."""
    return robot.model.joints[j].createData().S.ravel()
