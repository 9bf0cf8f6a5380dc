"""Joint temperatures among the state interfaces that ros2_control broadcasts."""

from collections import deque

DYNAMIC_JOINT_STATES = 'dynamic_joint_states'
_INTERFACE = 'temperature'  # ros2_control's name of the state interface
# Temperatures change over minutes, and broadcasters repeat them at 500 Hz. More than one message
# is read of each period [s], because a gripper's may come just before the arm's.
_PERIOD, _MOST = 0.1, 4


def temperatures_of(message):
    """Yield (joint, degC) of a control_msgs/DynamicJointState, whoever decoded it."""
    for joint, values in zip(message.joint_names, message.interface_values):
        for name, value in zip(values.interface_names, values.values):
            if name == _INTERFACE:
                yield joint, value


class FewOfMany:
    """Choose which messages are worth decoding."""

    def __init__(self):
        self._read = deque(maxlen=_MOST)

    def takes(self, now):
        """Return whether to decode the message received at now [s]."""
        if len(self._read) == _MOST and 0.0 <= now - self._read[0] < _PERIOD:
            return False
        self._read.append(now)
        return True
