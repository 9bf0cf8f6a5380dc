"""What the controller says and hears, as messages of the ROS interface."""

from array import array

import numpy as np
from builtin_interfaces.msg import Duration
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


def _duration(seconds):
    nanoseconds = int(round(seconds * 1e9))
    return Duration(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def _floats(values):
    return array('d', np.ascontiguousarray(values, dtype=float).tobytes())


def trajectory_message(joints, trajectory):
    """
    Return the JointTrajectory to follow from now on; its stamp of zero says so.

    trajectory: its time 0 is now. The knot at 0 is left out: a controller joins the first point
    to where it is.
    """
    message = JointTrajectory(joint_names=list(joints))
    for k in np.flatnonzero(trajectory.time > 1e-6):
        message.points.append(JointTrajectoryPoint(
            positions=_floats(trajectory.position[k]), velocities=_floats(trajectory.velocity[k]),
            accelerations=_floats(trajectory.acceleration[k]),
            time_from_start=_duration(trajectory.time[k])))
    return message


def limits_message(joints, limits, stamp):
    """Return JointTrajectory: point 0 the limits while accelerating, 1 while decelerating."""
    message = JointTrajectory(joint_names=list(joints))
    message.header.stamp = stamp
    message.points = [JointTrajectoryPoint(velocities=_floats(limits.velocity),
                                           accelerations=_floats(limit))
                      for limit in (limits.acceleration, limits.deceleration)]
    return message


def thresholds_message(joints, threshold, stamp):
    """Return JointState whose effort is the collision threshold (n,) [Nm]."""
    message = JointState(name=list(joints), effort=_floats(threshold))
    message.header.stamp = stamp
    return message


def effort_by_name(message, joints):
    """Return effort (n,) of a JointState in the order of `joints`; None when one is missing."""
    if len(message.effort) != len(message.name):
        return None
    efforts = dict(zip(message.name, message.effort))
    if any(joint not in efforts for joint in joints):
        return None
    return np.array([efforts[joint] for joint in joints])
