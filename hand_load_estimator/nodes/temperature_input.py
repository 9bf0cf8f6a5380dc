"""Joint temperatures from what robots publish."""

from rclpy.serialization import deserialize_message

from .qos import measurement
from ..stream.dynamic_joint_states import DYNAMIC_JOINT_STATES, FewOfMany, temperatures_of


def subscribe_dynamic_joint_states(node, depth, take):
    """
    Subscribe `dynamic_joint_states` and call take(joint, degC).

    Return the subscription, or None where control_msgs is not installed.
    """
    try:
        from control_msgs.msg import DynamicJointState
    except ImportError:
        return None
    few = FewOfMany()

    def received(data):
        if few.takes(node.get_clock().now().nanoseconds * 1e-9):
            for joint, celsius in temperatures_of(deserialize_message(data, DynamicJointState)):
                take(joint, celsius)

    # Raw, so that only the few messages that are read cost a conversion.
    return node.create_subscription(DynamicJointState, DYNAMIC_JOINT_STATES, received,
                                    measurement(depth), raw=True)
