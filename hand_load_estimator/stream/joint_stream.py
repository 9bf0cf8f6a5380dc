"""Messages in, MotionSamples out: the guard and the filter as nodes and files both use them."""

import numpy as np

from ..motion import Motion, MotionFilter
from .commanded_positions import CommandedPositions
from .input_guard import InputGuard

# What a joint of a robot can have [degC]; outside is a broken sensor or another unit.
PLAUSIBLE_TEMPERATURE = (-40.0, 150.0)
# A reading older than this [s] says nothing any more: joints warm over minutes.
TEMPERATURE_LIFE = 30.0


def joint_index(name, joints):
    """Return which of the joints a name means, also behind a tf_prefix; None if not just one."""
    if name in joints:
        return joints.index(name)
    matches = [i for i, joint in enumerate(joints) if name.endswith(joint)]
    return matches[0] if len(matches) == 1 else None


class TemperatureNames:
    """
    Which joint a temperature is of, where other arms' joints have the same names behind a prefix.

    A joint keeps the first name that told of it, and its own name wins; others are another arm's.
    """

    def __init__(self, joints):
        self._joints, self._name_of = joints, {}

    def index(self, name):
        """Return the joint's index, or None."""
        index = joint_index(name, self._joints)
        if index is None:
            return None
        if name == self._joints[index]:
            self._name_of[index] = name
        return index if self._name_of.setdefault(index, name) == name else None


class JointStream:
    """
    Feed raw messages of one robot, get filtered motion.

    rejected: reason -> count of everything not used.
    """

    def __init__(self, robot):
        self._guard = InputGuard(robot)
        self._names = TemperatureNames(robot.joints)
        self._filter = MotionFilter(robot.n)
        lag = robot.file.command_lag
        self._commands = None if lag is None else CommandedPositions(lag)
        self._read_at = np.full(robot.n, -np.inf)
        # No reading expires before this: joint states come too often to look at all of them.
        self._none_expires_before = -np.inf
        self.accepted = 0

    @property
    def rejected(self):
        """Counts of rejected input by reason."""
        return self._guard.rejected

    @property
    def passed_over(self):
        """Number of joint states that name no joint of the robot."""
        return self._guard.passed_over

    @property
    def why_none(self):
        """In words why no joint state was usable, as long as none was."""
        return self._guard.why_none

    @property
    def last_stamp(self):
        """Stamp [s] of the newest accepted message, or None."""
        return self._guard.last_stamp

    @property
    def temperature(self):
        """Last known temperatures (n,) [degC], NaN where unknown."""
        return self._filter.temperature

    def joint_state(self, stamp, names, position, velocity, effort):
        """Return a MotionSample when one is due, else None."""
        accepted = self._guard.accept(stamp, names, position, velocity, effort)
        if accepted is None:
            return None
        if self._guard.restarted:
            self._filter.restart()
        if self._commands is not None:
            accepted = self._as_followed(stamp, accepted)
        self.accepted += 1
        self._expire_temperatures(stamp)
        gaps = self._filter.gaps
        sample = self._filter.update(stamp, *accepted)
        if self._filter.gaps > gaps:
            self._guard.rejected['gap'] += 1
        return sample

    def _as_followed(self, stamp, commanded):
        if self._guard.restarted:
            self._commands.restart()
        return self._commands.update(stamp, commanded)

    def temperature_reading(self, joint, celsius):
        """Note one joint's temperature; other names are passed over, broken values counted."""
        index = self._names.index(joint)
        if index is None:
            return
        low, high = PLAUSIBLE_TEMPERATURE
        if not (np.isfinite(celsius) and low < celsius < high):
            self._guard.rejected['implausible_temperature'] += 1
            return
        self._filter.set_temperature(index, celsius)
        # Joint states tell the time; a reading before the first of them starts with it.
        now, expires = ((np.nan, -np.inf) if self.last_stamp is None
                        else (self.last_stamp, self.last_stamp + TEMPERATURE_LIFE))
        self._read_at[index] = now
        self._none_expires_before = min(self._none_expires_before, expires)

    def _expire_temperatures(self, stamp):
        if stamp <= self._none_expires_before:
            return
        self._read_at[np.isnan(self._read_at)] = stamp
        for joint in np.flatnonzero(stamp - self._read_at > TEMPERATURE_LIFE):
            if np.isfinite(self._filter.temperature[joint]):
                self._filter.set_temperature(joint, np.nan)
                self._guard.rejected['temperature_expired'] += 1
                self._read_at[joint] = -np.inf
        known = self._read_at[self._read_at > -np.inf]
        self._none_expires_before = min(known, default=stamp) + TEMPERATURE_LIFE


def motion_samples(stream, recording):
    """Yield the MotionSamples of a Recording through a JointStream."""
    for item in recording.samples:
        if hasattr(item, 'joint'):
            stream.temperature_reading(item.joint, item.value)
            continue
        sample = stream.joint_state(item.stamp, item.names, item.position, item.velocity,
                                    item.effort)
        if sample is not None:
            yield sample


def motion_of(robot, recording):
    """Return (Motion, rejected counts) of a Recording."""
    stream = JointStream(robot)
    return Motion.of(list(motion_samples(stream, recording))), dict(stream.rejected)
