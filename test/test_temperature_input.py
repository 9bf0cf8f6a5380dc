"""Temperatures out of ros2_control's dynamic_joint_states, without its message package."""

import math
import sys
from types import ModuleType, SimpleNamespace

from dynamic_joint_helpers import control_msgs, dynamic_joint_state, KIND
import pytest

from hand_load_estimator.nodes import temperature_input
from hand_load_estimator.stream.dynamic_joint_states import temperatures_of


def test_temperatures_of_dynamic_joint_state():
    """control_msgs is not needed to know how its message is read."""
    class Values:
        def __init__(self, names, values):
            self.interface_names, self.values = names, values

    class Message:
        joint_names = ['a', 'b', 'c']
        interface_values = [Values(['position', 'temperature'], [0.1, 31.5]),
                            Values(['position'], [0.2]), Values(['temperature'], [math.nan])]

    read = list(temperatures_of(Message))
    assert read[0] == ('a', 31.5) and read[1][0] == 'c' and math.isnan(read[1][1])
    assert len(read) == 2


@pytest.fixture
def store(monkeypatch):
    """Return the rosbags types of control_msgs in place of ROS's own, which are no wheel."""
    store = control_msgs()
    for name in ('control_msgs', 'control_msgs.msg'):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules['control_msgs.msg'].DynamicJointState = store.types[KIND]
    monkeypatch.setattr(temperature_input, 'deserialize_message', lambda data, asked:
                        store.deserialize_cdr(data, asked.__msgtype__))
    return store


@pytest.fixture
def subscribed():
    """Return the clock [s] of a node, what it takes, and what it subscribes with."""
    now, taken, made = [0.0], [], []
    node = SimpleNamespace(
        get_clock=lambda: SimpleNamespace(now=lambda: SimpleNamespace(
            nanoseconds=int(now[0] * 1e9))),
        create_subscription=lambda *given, **more: made.append((given, more)))
    temperature_input.subscribe_dynamic_joint_states(node, 100, lambda *pair: taken.append(pair))
    return now, taken, made[0]


def test_of_many_dynamic_joint_states_some_are_read(store, subscribed):
    """What arrives over DDS is raw bytes; of 500 messages a second 40 are read."""
    now, taken, ((kind, topic, received, _), keywords) = subscribed
    assert kind.__msgtype__ == 'control_msgs/msg/DynamicJointState'
    assert topic == 'dynamic_joint_states' and keywords == {'raw': True}
    for k in range(500):
        now[0] = 7.0 + 0.002 * k
        received(dynamic_joint_state(store, ('a', 'b'), (30.0 + now[0], 40.0)))
    assert taken[:2] == [('a', 37.0), ('b', 40.0)] and 36 <= len(taken) / 2 <= 40
    now[0] = 1.0
    received(dynamic_joint_state(store, ('a',), (20.0,)))
    assert taken[-1] == ('a', 20.0), 'a clock that goes back does not stop it'


def test_a_gripper_heard_just_before_the_arm_does_not_hide_it(store, subscribed):
    now, taken, ((*_, received, _), _) = subscribed
    for k in range(20):
        for joint, later in (('gripper', 0.0), ('a', 0.001)):
            now[0] = 7.0 + 0.1 * k + later
            received(dynamic_joint_state(store, (joint,), (30.0,)))
    assert [joint for joint, _ in taken] == ['gripper', 'a'] * 20


def test_without_control_msgs_nothing_is_subscribed(monkeypatch):
    monkeypatch.setitem(sys.modules, 'control_msgs.msg', None)
    assert temperature_input.subscribe_dynamic_joint_states(None, 100, None) is None
