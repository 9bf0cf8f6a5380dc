"""Joint temperatures from what robots publish."""

from rclpy.serialization import deserialize_message

from .qos import measurement

_INTERFACE = 'temperature'  # ros2_control's name of the state interface
_PERIOD = 0.1  # [s] temperatures change over minutes; broadcasters repeat them at 500 Hz


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
    last = [None]

    def received(data):
        now = node.get_clock().now().nanoseconds * 1e-9
        if last[0] is not None and 0.0 <= now - last[0] < _PERIOD:
            return
        last[0] = now
        message = deserialize_message(data, DynamicJointState)
        for joint, celsius in temperatures_of(message):
            take(joint, celsius)

    # Raw, so that only the few messages that are read cost a conversion.
    return node.create_subscription(DynamicJointState, 'dynamic_joint_states', received,
                                    measurement(depth), raw=True)
