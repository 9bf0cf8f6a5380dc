"""Messages of ros2_control's joint state broadcaster, whose package is no wheel."""

import numpy as np
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

KIND = 'control_msgs/msg/DynamicJointState'


def control_msgs():
    """Return the rosbags store of ROS's types and control_msgs'."""
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register({
        **get_types_from_msg('string[] interface_names\nfloat64[] values',
                             'control_msgs/msg/InterfaceValue'),
        **get_types_from_msg('std_msgs/Header header\nstring[] joint_names\n'
                             'InterfaceValue[] interface_values', KIND)})
    return store


def dynamic_joint_state(store, joints, celsius, seconds=1):
    """Return the CDR bytes the broadcaster sends: two interfaces of each joint."""
    types = store.types
    values = types['control_msgs/msg/InterfaceValue']
    header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](seconds, 2), '')
    message = types[KIND](
        header, list(joints), [values(['position', 'temperature'], np.array([0.1, c]))
                               for c in celsius])
    return bytes(store.serialize_cdr(message, KIND))
