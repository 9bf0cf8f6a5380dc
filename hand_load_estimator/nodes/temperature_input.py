"""Joint temperatures from what robots publish."""

from collections import deque

from rclpy.serialization import deserialize_message

from .qos import measurement

_INTERFACE = 'temperature'  # ros2_control's name of the state interface
# Temperatures change over minutes, and broadcasters repeat them at 500 Hz. More than one message
# is read of each period [s], because a gripper's may come just before the arm's.
_PERIOD, _MOST = 0.1, 4


def temperatures_of(message):
    """Yield (joint, degC) of a control_msgs/DynamicJointState."""
    for joint, values in zip(message.joint_names, message.interface_values):
        for name, value in zip(values.interface_names, values.values):
            if name == _INTERFACE:
                yield joint, value


def subscribe_dynamic_joint_states(node, depth, take):
    """
    Subscribe `dynamic_joint_states` and call take(joint, degC).

    Return the subscription, or None where control_msgs is not installed.
    """
    try:
        from control_msgs.msg import DynamicJointState
    except ImportError:
        return None
    read = deque(maxlen=_MOST)

    def received(data):
        now = node.get_clock().now().nanoseconds * 1e-9
        if len(read) == _MOST and 0.0 <= now - read[0] < _PERIOD:
            return
        read.append(now)
        message = deserialize_message(data, DynamicJointState)
        for joint, celsius in temperatures_of(message):
            take(joint, celsius)

    # Raw, so that only the few messages that are read cost a conversion.
    return node.create_subscription(DynamicJointState, 'dynamic_joint_states', received,
                                    measurement(depth), raw=True)
