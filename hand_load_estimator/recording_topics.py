"""Which topics of a rosbag2 recording hold joint states and joint temperatures."""

from rosbags.typesys import get_types_from_msg, get_typestore, Stores

from .errors import RecordingError
from .stream.dynamic_joint_states import DYNAMIC_JOINT_STATES

JOINT_STATES = 'joint_states'
TEMPERATURES = 'joint_temperatures'
NO_TEMPERATURES = 'none'
JOINT_STATE_TYPE = 'sensor_msgs/msg/JointState'
TEMPERATURE_TYPE = 'sensor_msgs/msg/Temperature'
DYNAMIC_TYPE = 'control_msgs/msg/DynamicJointState'

STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register({
    **get_types_from_msg('string[] interface_names\nfloat64[] values',
                         'control_msgs/msg/InterfaceValue'),
    **get_types_from_msg('std_msgs/Header header\nstring[] joint_names\n'
                         'InterfaceValue[] interface_values', DYNAMIC_TYPE)})


def wanted_connections(bag, path, joint_states, temperatures):
    """
    Return the connections of a bag to read; RecordingError when they cannot be used.

    joint_states, temperatures: names of topics; temperatures are optional unless asked for by
    another name than TEMPERATURES.
    """
    return (_connections(bag, path, joint_states, (JOINT_STATE_TYPE,), True)
            + _temperature_connections(bag, path, joint_states, temperatures))


def _named(bag, topic):
    return [c for c in bag.connections if c.topic.lstrip('/') == topic.lstrip('/')]


def _connections(bag, path, topic, allowed, required, otherwise=''):
    """
    Return the bag's connections of a topic; RecordingError when they cannot be used.

    otherwise: what else the user may do where the topic is of another type.
    """
    found = _named(bag, topic)
    if not found and required:
        there = ', '.join(sorted({f'{c.topic} ({c.msgtype})' for c in bag.connections}))
        raise RecordingError(f'{path}: has no topic {topic!r}; topics in it: {there or "none"}; '
                             'name the right one with --joint-states or --temperatures')
    for connection in found:
        if connection.msgtype not in allowed:
            raise RecordingError(f'{path}: topic {connection.topic!r} is a {connection.msgtype}; '
                                 f'allowed: {" or ".join(allowed)}{otherwise}')
    return found


def _temperature_connections(bag, path, joint_states, topic):
    """Return the connections of temperatures: what a node beside the recorder would hear."""
    if topic == NO_TEMPERATURES:
        return []
    otherwise = f'; `--temperatures {NO_TEMPERATURES}` reads the recording without'
    if topic != TEMPERATURES:
        return _connections(bag, path, topic, (TEMPERATURE_TYPE, DYNAMIC_TYPE), True, otherwise)
    # A driver in a namespace has both of its topics there, a node beside it may not.
    places = f'{joint_states.rpartition("/")[0]}/', ''
    told = (_connections(bag, path, place + topic, (TEMPERATURE_TYPE,), False, otherwise)
            for place in places)
    broadcast = ([c for c in _named(bag, place + DYNAMIC_JOINT_STATES)
                  if c.msgtype == DYNAMIC_TYPE] for place in places)
    return next(filter(None, told), []) + next(filter(None, broadcast), [])
