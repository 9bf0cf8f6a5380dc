"""Temperatures are read from a recording wherever a node beside the recorder would hear them."""

from core_helpers import exact_model
from dynamic_joint_helpers import control_msgs, dynamic_joint_state, KIND
import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer

from hand_load_estimator.errors import RecordingError
from hand_load_estimator.recording import read_recording
from hand_load_estimator.stream.joint_stream import motion_of

STORE = control_msgs()
JOINT_STATE, TEMPERATURE = 'sensor_msgs/msg/JointState', 'sensor_msgs/msg/Temperature'
JOINTS = tuple(exact_model('four').robot.joints)


def message(kind, seconds, celsius):
    """Return the CDR bytes of a message at some time [s], of all joints at one temperature."""
    if kind == KIND:
        return dynamic_joint_state(STORE, (*JOINTS, 'finger'), [celsius] * 4 + [99.0],
                                   int(seconds))
    types = STORE.types
    header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](
        int(seconds), round(seconds % 1.0 * 1e9)), JOINTS[0])
    zeros = np.zeros(len(JOINTS))
    content = ((celsius, 0.0) if kind == TEMPERATURE else (list(JOINTS), zeros, zeros, zeros))
    return bytes(STORE.serialize_cdr(types[kind](header, *content), kind))


def bag(folder, topics, seconds=2.0, rate=100):
    """Write a recording of topics {name: (type, degC)} at a rate [Hz]; return its folder."""
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        made = {name: writer.add_connection(name, kind, typestore=STORE)
                for name, (kind, _) in topics.items()}
        for k in range(int(seconds * rate)):
            for name, (kind, celsius) in topics.items():
                writer.write(made[name], int(k * 1e9 / rate) + 1,
                             message(kind, k / rate, celsius))
    return folder


def test_the_broadcasters_temperatures_are_those_of_the_motion(tmp_path):
    recorded = read_recording(bag(tmp_path / 'bag', {
        '/joint_states': (JOINT_STATE, 0.0), '/dynamic_joint_states': (KIND, 31.0)}))
    motion, rejected = motion_of(exact_model('four').robot, recorded)
    assert (motion.temperature[10:] == 31.0).all() and not rejected
    # Of 100 messages a second at most 40 are decoded, each of four joints and a finger.
    assert len(recorded.joint_samples) == 200
    assert 70 <= len(recorded.temperature_samples) / 5 <= 80


def test_both_ways_of_telling_temperatures_are_heard(tmp_path):
    told = read_recording(bag(tmp_path / 'bag', {
        '/joint_states': (JOINT_STATE, 0.0), '/dynamic_joint_states': (KIND, 31.0),
        '/joint_temperatures': (TEMPERATURE, 32.0)})).temperature_samples
    assert {(s.joint, s.value) for s in told} == {
        *((joint, 31.0) for joint in JOINTS), ('finger', 99.0), (JOINTS[0], 32.0)}


@pytest.mark.parametrize('place, celsius', [('/left', 31.0), ('', 30.0)])
def test_those_beside_the_joint_states_come_first(tmp_path, place, celsius):
    folder = bag(tmp_path / 'bag', {
        '/left/joint_states': (JOINT_STATE, 0.0), f'{place}/dynamic_joint_states': (KIND, celsius),
        '/right/dynamic_joint_states': (KIND, 50.0)}, 0.1)
    told = read_recording(folder, 'left/joint_states').temperature_samples
    assert {s.value for s in told if s.joint in JOINTS} == {celsius}
    (only,) = {s.value for s in read_recording(
        folder, 'left/joint_states', '/right/dynamic_joint_states').temperature_samples
        if s.joint in JOINTS}
    assert only == 50.0
    assert not read_recording(folder, 'left/joint_states', 'none').temperature_samples


def test_where_temperatures_are_beside_the_joint_states_others_do_not_matter(tmp_path):
    folder = bag(tmp_path / 'bag', {
        '/left/joint_states': (JOINT_STATE, 0.0), '/left/joint_temperatures': (TEMPERATURE, 30.0),
        '/joint_temperatures': (JOINT_STATE, 0.0)}, 0.1)
    told = read_recording(folder, 'left/joint_states').temperature_samples
    assert {s.value for s in told} == {30.0}


def test_another_type_under_that_name_is_nobodys_temperature(tmp_path):
    folder = bag(tmp_path / 'bag', {'/joint_states': (JOINT_STATE, 0.0),
                                    '/dynamic_joint_states': (JOINT_STATE, 0.0)}, 0.1)
    assert not read_recording(folder).temperature_samples
    with pytest.raises(RecordingError, match='allowed: .*Temperature or control_msgs'):
        read_recording(folder, temperatures='dynamic_joint_states')
