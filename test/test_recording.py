"""Recordings are read and written without changing what they say; wrong ones are refused."""

import os
from pathlib import Path

from hand_load_estimator.errors import ConfigurationError, RecordingError
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.recording import (_message, arrays, JointSample,
                                           read_recording, RecordingWriter, TemperatureSample)
import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

DATA = Path(os.environ.get('HAND_LOAD_DATA', Path(__file__).parents[2] / 'shared' / 'data'))
NAMES = ('a', 'b')


def joint(stamp, values=(1.0, 2.0), names=NAMES):
    values = np.array(values)
    return JointSample(stamp, names, values, values + 10.0, values + 20.0)


def write(path, samples):
    with RecordingWriter(path) as writer:
        for sample in samples:
            writer.write(sample)
    return path


def same(one, other):
    if type(one) is not type(other) or one.stamp != pytest.approx(other.stamp, abs=1e-9):
        return False
    if isinstance(one, TemperatureSample):
        return one.joint == other.joint and np.array_equal(one.value, other.value, equal_nan=True)
    return one.names == other.names and all(
        np.array_equal(getattr(one, k), getattr(other, k), equal_nan=True)
        for k in ('position', 'velocity', 'effort'))


def test_round_trip_keeps_order_and_odd_contents(tmp_path):
    none = np.zeros(0)
    samples = [
        joint(5.0), joint(5.0, (3.0, 4.0)), joint(4.2), joint(0.0),
        TemperatureSample(4.0, 'a', 25.5), joint(6.0, (np.nan, np.inf)),
        JointSample(6.1, NAMES, none, none, none),
        JointSample(6.2, (), none, none, none), JointSample(6.3, ('b',), np.ones(3), none, none),
        TemperatureSample(6.4, 'b', np.nan), joint(1.7e9 + 0.25)]
    read = read_recording(write(tmp_path / 'bag', samples)).samples
    assert len(read) == len(samples)
    assert all(same(one, other) for one, other in zip(samples, read))


def test_many_messages_keep_their_order_over_chunks(tmp_path):
    samples = [joint(0.002 * k) if k % 5 else TemperatureSample(0.002 * k, 'a', float(k))
               for k in range(20000)]
    read = read_recording(write(tmp_path / 'bag', samples)).samples
    assert [s.stamp for s in read] == pytest.approx([s.stamp for s in samples])


def test_topics_match_with_or_without_slash(tmp_path):
    bag = write(tmp_path / 'bag', [joint(1.0), TemperatureSample(1.0, 'a', 20.0)])
    assert len(read_recording(bag, '/joint_states', '/joint_temperatures').samples) == 2


def test_missing_topic_names_those_there(tmp_path):
    bag = write(tmp_path / 'bag', [joint(1.0)])
    with pytest.raises(RecordingError, match='left/joint_states.*/joint_states '):
        read_recording(bag, 'left/joint_states')
    with pytest.raises(RecordingError, match='motor_temperatures'):
        read_recording(bag, temperatures='motor_temperatures')


@pytest.mark.parametrize('place', ['/left', ''])
def test_temperatures_are_looked_for_beside_the_joint_states(tmp_path, place):
    bag = write(tmp_path / 'bag', [joint(1.0), TemperatureSample(1.0, 'a', 20.0)])
    other = tmp_path / 'left'
    with Writer(other, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        store = get_typestore(Stores.ROS2_JAZZY)
        topics = {kind: writer.add_connection(topic, kind, typestore=store) for kind, topic in (
            ('sensor_msgs/msg/JointState', '/left/joint_states'),
            ('sensor_msgs/msg/Temperature', f'{place}/joint_temperatures'))}
        for sample in read_recording(bag).samples:
            message = _message(sample)
            writer.write(topics[message.__msgtype__], 10**9,
                         store.serialize_cdr(message, message.__msgtype__))
    for asked in ('joint_temperatures', f'{place}/joint_temperatures'):
        read = read_recording(other, '/left/joint_states', asked)
        assert [sample.value for sample in read.temperature_samples] == [20.0]
    assert not read_recording(bag, temperatures='none').temperature_samples


def test_wrong_type_is_refused(tmp_path):
    bag = write(tmp_path / 'bag', [joint(1.0)])
    with pytest.raises(RecordingError, match='sensor_msgs/msg/Temperature; allowed'):
        read_recording(bag, joint_states='joint_temperatures')


def test_what_is_no_recording_is_refused(tmp_path):
    with pytest.raises(RecordingError, match='is not there'):
        read_recording(tmp_path / 'nothing')
    with pytest.raises(RecordingError, match='no metadata.yaml'):
        read_recording(tmp_path)
    file = tmp_path / 'file.mcap'
    file.write_bytes(b'x')
    with pytest.raises(RecordingError, match='is a file'):
        read_recording(file)


@pytest.mark.parametrize('keep', [0.0, 0.001, 0.3, 0.7, 0.999])
def test_truncated_file_is_refused(tmp_path, keep):
    bag = write(tmp_path / 'bag', [joint(0.01 * k) for k in range(300)])
    file = bag / 'bag.mcap'
    content = file.read_bytes()
    file.write_bytes(content[:int(keep * len(content))])
    with pytest.raises(RecordingError, match='damaged'):
        read_recording(bag)


def test_flipped_bytes_never_raise_anything_else(tmp_path):
    bag = write(tmp_path / 'bag', [joint(0.01 * k) for k in range(50)])
    file, random = bag / 'bag.mcap', np.random.default_rng(1)
    content, refused = file.read_bytes(), 0
    for _ in range(60):
        broken = bytearray(content)
        for place in random.integers(0, len(broken), 20):
            broken[place] ^= 0xff
        file.write_bytes(bytes(broken))
        try:
            read_recording(bag)
        except RecordingError:
            refused += 1
    assert refused > 40


@pytest.mark.parametrize('metadata', ['', 'a: [', 'rosbag2_bagfile_information: 3',
                                      'rosbag2_bagfile_information: {version: 99}'])
def test_broken_metadata_is_refused(tmp_path, metadata):
    bag = write(tmp_path / 'bag', [joint(1.0)])
    (bag / 'metadata.yaml').write_text(metadata)
    with pytest.raises(RecordingError, match='damaged'):
        read_recording(bag)


def test_sqlite3_is_read(tmp_path):
    store = get_typestore(Stores.ROS2_JAZZY)
    types = store.types
    header = types['std_msgs/msg/Header'](
        stamp=types['builtin_interfaces/msg/Time'](sec=3, nanosec=500_000_000), frame_id='')
    message = types['sensor_msgs/msg/JointState'](
        header=header, name=['a'], position=np.array([1.5]), velocity=np.zeros(0),
        effort=np.array([2.5]))
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        topic = bag.add_connection('/arm/joint_states', message.__msgtype__, typestore=store)
        bag.write(topic, 7, store.serialize_cdr(message, message.__msgtype__))
    sample, = read_recording(tmp_path / 'bag', 'arm/joint_states').samples
    assert same(sample, JointSample(3.5, ('a',), np.array([1.5]), np.zeros(0), np.array([2.5])))


def test_load_file_is_read_only_when_wanted(tmp_path):
    bag = write(tmp_path / 'bag', [joint(1.0)])
    assert read_recording(bag).load is None
    write_load_file(bag / 'load.yaml', LoadParameters(2.5, [0.0, 0.0, 0.1], 0.01 * np.eye(3)))
    recording = read_recording(bag)
    assert recording.load.mass == 2.5
    assert recording.load_known == ('mass', 'com', 'inertia')
    (bag / 'load.yaml').write_text('mass: -1')
    with pytest.raises(ConfigurationError, match='mass'):
        read_recording(bag)
    assert read_recording(bag, with_load=False).load is None


def test_writer_refuses_what_exists_and_leaves_no_whole_bag_after_an_error(tmp_path):
    with pytest.raises(RecordingError, match='exists already'):
        RecordingWriter(tmp_path)
    with pytest.raises(ZeroDivisionError):
        with RecordingWriter(tmp_path / 'bag') as writer:
            writer.write(joint(1.0))
            raise ZeroDivisionError
    with pytest.raises(RecordingError):
        read_recording(tmp_path / 'bag')


def test_arrays_skip_other_joints_and_fill_with_nan(tmp_path):
    samples = [joint(1.0), JointSample(1.1, ('gripper',), np.ones(1), np.ones(1), np.ones(1)),
               joint(1.2, (4.0, 5.0, 6.0), ('b', 'x', 'a')),
               JointSample(1.3, NAMES, np.array([7.0, 8.0]), np.zeros(0), np.zeros(1))]
    recording = read_recording(write(tmp_path / 'b', samples))
    time, position, velocity, effort = arrays(recording, NAMES)
    assert time == pytest.approx([1.0, 1.2, 1.3])
    assert np.array_equal(position, [[1.0, 2.0], [6.0, 4.0], [7.0, 8.0]])
    assert np.isnan(velocity[2]).all() and np.isnan(effort[2]).all()
    assert np.array_equal(effort[1], [26.0, 24.0])


def test_arrays_of_nothing_have_their_shape(tmp_path):
    time, position, *_ = arrays(read_recording(write(tmp_path / 'b', [])), NAMES)
    assert time.shape == (0,) and position.shape == (0, 2)


@pytest.mark.skipif(not (DATA / 'nist_ur5').is_dir(), reason=f'no recordings at {DATA}')
def test_real_recording_with_temperatures():
    recording = read_recording(DATA / 'nist_ur5' / 'halfspeed_1p6lb_1')
    assert len(recording.joint_samples) == 7906
    assert len(recording.temperature_samples) > 3600
    assert {s.joint for s in recording.temperature_samples} == set(recording.samples[0].names)
    assert 20.0 < np.median([s.value for s in recording.temperature_samples]) < 35.0
