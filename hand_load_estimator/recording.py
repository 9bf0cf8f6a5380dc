"""Recordings: rosbag2 folders (MCAP or sqlite3) of joint states and joint temperatures."""

from dataclasses import dataclass
import math
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import (CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer,
                             WriterError)

from .errors import RecordingError
from .files.load_file import read_load_file
from .load import LoadParameters
from .recording_topics import (DYNAMIC_TYPE, JOINT_STATE_TYPE, JOINT_STATES, STORE,
                               TEMPERATURE_TYPE, TEMPERATURES, wanted_connections)
from .stream.arm_names import ArmNames
from .stream.dynamic_joint_states import FewOfMany, temperatures_of

_BAG_VERSION = 9
_Time = STORE.types['builtin_interfaces/msg/Time']
_Header = STORE.types['std_msgs/msg/Header']


@dataclass(frozen=True)
class JointSample:
    """
    One JointState message as it was recorded.

    stamp [s] of its header; names (k,); position [rad], velocity [rad/s] and effort (by the
    robot file), each (k,) in a well-formed message, of any other length or empty in others.
    """

    stamp: float
    names: tuple
    position: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray


@dataclass(frozen=True)
class TemperatureSample:
    """One joint's temperature: stamp [s] of its message's header, joint name, value [degC]."""

    stamp: float
    joint: str
    value: float


@dataclass(frozen=True)
class Recording:
    """
    What a recording holds.

    path of its folder; samples (JointSample and TemperatureSample) in recorded order; load, the
    LoadParameters of its load.yaml or None; load_known: which of mass, com, inertia it states,
    and ASSUMED (load_file.py) where it says so.
    """

    path: Path
    samples: list
    load: LoadParameters | None = None
    load_known: tuple = ()

    @property
    def joint_samples(self):
        """The JointSamples in recorded order."""
        return [s for s in self.samples if isinstance(s, JointSample)]

    @property
    def temperature_samples(self):
        """The TemperatureSamples in recorded order."""
        return [s for s in self.samples if isinstance(s, TemperatureSample)]


def _seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def _samples_of(message):
    stamp = _seconds(message.header.stamp)
    if message.__msgtype__ == JOINT_STATE_TYPE:
        return [JointSample(stamp, tuple(message.name), message.position, message.velocity,
                            message.effort)]
    if message.__msgtype__ == DYNAMIC_TYPE:
        return [TemperatureSample(stamp, joint, float(celsius))
                for joint, celsius in temperatures_of(message)]
    return [TemperatureSample(stamp, message.header.frame_id, float(message.temperature))]


def _samples(path, joint_states, temperatures):
    few, found = FewOfMany(), []
    with Reader(path) as bag:
        wanted = wanted_connections(bag, path, joint_states, temperatures)
        for connection, logged, raw in bag.messages(wanted):
            if connection.msgtype != DYNAMIC_TYPE or few.takes(1e-9 * logged):
                found += _samples_of(STORE.deserialize_cdr(raw, connection.msgtype))
    return found


def _refuse_other_than_bag(path):
    if not path.exists():
        raise RecordingError(f'{path}: is not there; give the folder of a rosbag2 recording')
    if not path.is_dir():
        raise RecordingError(f'{path}: is a file; give the folder of a rosbag2 recording '
                             '(the one with metadata.yaml in it)')
    if not (path / 'metadata.yaml').is_file():
        raise RecordingError(f'{path}: is not a rosbag2 recording (no metadata.yaml in it); when '
                             'its recorder was killed, `ros2 bag reindex` writes one')


def read_recording(path, joint_states=JOINT_STATES, temperatures=TEMPERATURES, with_load=True):
    """
    Return the Recording in a rosbag2 folder.

    Topics match with or without a leading slash; namespaces must match exactly. Temperatures by
    their usual name are looked for in the namespace of the joint states, then without one, and
    so are those in ros2_control's dynamic_joint_states; NO_TEMPERATURES leaves both out.
    with_load=False leaves load.yaml unread. Contents are passed on as they are, NaN and empty
    arrays included.
    Raises RecordingError when the folder cannot be read, ConfigurationError for a wrong load.yaml.
    """
    path = Path(path)
    _refuse_other_than_bag(path)
    try:
        samples = _samples(path, joint_states, temperatures)
    except RecordingError:
        raise
    # A damaged file can surface as any exception of the reader, the decompressor or the decoder.
    except Exception as error:
        reason = ' '.join(str(error).split()) or type(error).__name__
        raise RecordingError(f'{path}: is damaged or incomplete ({reason}); record or copy it '
                             'again, or try `ros2 bag reindex`') from None
    load_file = path / 'load.yaml'
    load, known = (read_load_file(load_file) if with_load and load_file.is_file()
                   else (None, ()))
    return Recording(path, samples, load, known)


def _nanoseconds(stamp):
    # Seconds of today times 1e9 do not fit a double; the fraction alone does.
    seconds = math.floor(stamp)
    return seconds * 10**9 + round((stamp - seconds) * 1e9)


def _ros_time(stamp):
    seconds, nanoseconds = divmod(_nanoseconds(stamp), 10**9)
    return _Time(sec=seconds, nanosec=nanoseconds)


def _doubles(values):
    return np.ascontiguousarray(values, dtype=np.float64)


def _message(sample):
    if isinstance(sample, JointSample):
        return STORE.types[JOINT_STATE_TYPE](
            header=_Header(stamp=_ros_time(sample.stamp), frame_id=''), name=list(sample.names),
            position=_doubles(sample.position), velocity=_doubles(sample.velocity),
            effort=_doubles(sample.effort))
    return STORE.types[TEMPERATURE_TYPE](
        header=_Header(stamp=_ros_time(sample.stamp), frame_id=sample.joint),
        temperature=float(sample.value), variance=0.0)


class RecordingWriter:
    """
    Write samples to a new rosbag2 folder (MCAP); use as a context manager.

    The log time is the stamp, or just after the last message where stamps repeat or go back, so
    that reading gives the samples in the order they were written. RecordingError when the folder
    exists or cannot be made.
    """

    def __init__(self, path):
        self._path = Path(path)
        self._writer = Writer(self._unused_path(), version=_BAG_VERSION,
                              storage_plugin=StoragePlugin.MCAP)
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._topics, self._last = {}, -1

    def _unused_path(self):
        if self._path.exists():
            raise RecordingError(f'{self._path}: exists already; give the name of a new folder')
        return self._path

    def __enter__(self):
        try:
            self._writer.open()
        except (OSError, WriterError) as error:
            raise RecordingError(f'{self._path}: cannot be made ({error})') from None
        for kind, topic, msgtype in ((JointSample, JOINT_STATES, JOINT_STATE_TYPE),
                                     (TemperatureSample, TEMPERATURES, TEMPERATURE_TYPE)):
            self._topics[kind] = self._writer.add_connection(f'/{topic}', msgtype,
                                                             typestore=STORE)
        return self

    def __exit__(self, *exception):
        return self._writer.__exit__(*exception)

    def write(self, sample):
        """Append a JointSample or TemperatureSample."""
        message = _message(sample)
        self._last = max(self._last + 1, _nanoseconds(sample.stamp))
        self._writer.write(self._topics[type(sample)], self._last,
                           STORE.serialize_cdr(message, message.__msgtype__))


def _picked(values, indices, size):
    """Return the wanted values, NaN when the array does not belong to all names."""
    return values[indices] if len(values) == size else np.full(len(indices), np.nan)


def arrays(recording, joints):
    """
    Return time (N,) [s] and position, velocity, effort (N, n) of the messages with all joints.

    In recorded order, joints in the order asked for; NaN where a message has no such value.
    """
    arm, rows = ArmNames(joints), []
    for sample in recording.joint_samples:
        indices = arm.index(sample.names, sample.stamp)
        if isinstance(indices, np.ndarray):
            size = len(sample.names)
            rows.append((sample.stamp, *(_picked(values, indices, size) for values in
                                         (sample.position, sample.velocity, sample.effort))))
    if not rows:
        empty = np.empty((0, len(joints)))
        return np.empty(0), empty, empty.copy(), empty.copy()
    time, position, velocity, effort = zip(*rows)
    return np.array(time), np.array(position), np.array(velocity), np.array(effort)
