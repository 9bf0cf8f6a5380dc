"""Are two robot files of the same arm? Their URDFs tell by where each joint lies on its link."""

import numpy as np
import pinocchio as pin

# Factory calibrations of UR arms move joints by up to 1 mm and turn them by up to 0.007 rad. Arms
# with the same joint names lie 19 mm (UR3, UR3e) or more apart at some joint (UR10, UR10e: 24 mm).
SAME_PLACE, SAME_DIRECTION = 0.010, 0.1    # [m], [rad]


def places_of(robot):
    """
    Return where each joint of a Robot lies, as lists of 12 numbers a file can keep.

    Offset (3) [m] and rotation vector (3) [rad] on its link, direction (6) of its motion in its
    own frame. The first joint's place says where the arm stands and is zero here.
    """
    out = []
    for j in range(1, robot.n + 1):
        place = robot.model.jointPlacements[j] if j > 1 else pin.SE3.Identity()
        axis = robot.model.joints[j].createData().S.ravel()
        out.append(np.concatenate([place.translation, pin.log3(place.rotation), axis])
                   .round(9).tolist())
    return out


def arm_difference(one, other):
    """Return in words where two Robots with the same joint names differ most, '' for the same."""
    return place_difference(places_of(one), other)


def place_difference(places, robot):
    """Return in words where places_of() an arm differ most from a Robot's, '' for the same arm."""
    apart = [(joint, *_joint_difference(np.array(one), np.array(other)))
             for joint, one, other in zip(robot.joints, places, places_of(robot))]
    joint, distance, _ = max(apart, key=lambda found: found[1])
    if distance > SAME_PLACE:
        return f'{joint} lies {1e3 * distance:.0f} mm from where {robot.name} has it'
    joint, _, angle = max(apart, key=lambda found: found[2])
    if angle > SAME_DIRECTION:
        return f'{joint} is turned by {angle:.2f} rad from where {robot.name} has it'
    return ''


def _joint_difference(one, other):
    """Return distance [m] and angle [rad] between two places (12,) of a joint."""
    turn = pin.log3(pin.exp3(one[3:6]).T @ pin.exp3(other[3:6]))
    # A hinge and a slide have nothing in common: a quarter turn.
    between = np.arccos(np.clip(one[6:] @ other[6:], -1.0, 1.0))
    return np.linalg.norm(one[:3] - other[:3]), max(np.linalg.norm(turn), between)
