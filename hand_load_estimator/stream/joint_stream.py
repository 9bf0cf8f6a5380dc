"""Messages in, MotionSamples out: the guard and the filter as nodes and files both use them."""

import math

from ..motion import Motion, MotionFilter
from .arm_names import refuse_several
from .commanded_positions import CommandedPositions
from .input_guard import InputGuard
from .joint_temperatures import JointTemperatures


class JointStream:
    """
    Feed raw messages of one robot, get filtered motion.

    rejected: reason -> count of everything not used; accepted: number of joint states used; arms:
    behind how many prefixes they came, one after the other, 1 for one arm.
    """

    def __init__(self, robot):
        self._guard = InputGuard(robot)
        self._temperatures = JointTemperatures(robot.joints)
        self._filter = MotionFilter(robot.n, self._temperatures.values)
        lag = robot.file.command_lag
        self._commands = None if lag is None else CommandedPositions(lag)
        self.accepted, self.arms = 0, 0

    @property
    def rejected(self):
        """Counts of rejected input by reason."""
        return self._guard.rejected + self._temperatures.rejected

    @property
    def passed_over(self):
        """Number of joint states that name no joint of the robot, or another arm's."""
        return self._guard.passed_over

    @property
    def names(self):
        """The ArmNames that tell which joint states are this arm's."""
        return self._guard.names

    @property
    def turns(self):
        """Whole turns (n,) [rad] that positions of samples are ahead of what is reported."""
        return 0.0 if self._guard.turns is None else self._guard.turns

    @property
    def frozen(self):
        """For how long [s] joint states have been the same to the last bit."""
        return self._guard.frozen

    @property
    def velocity_stuck(self):
        """Which joints' (n,) velocities are zero while they move: all are done without then."""
        return self._guard.velocity_stuck

    @property
    def temperature_names(self):
        """The names (list) that temperatures are taken from, and others alike that are not."""
        return self._temperatures.names

    @property
    def why_none(self):
        """In words why no joint state was usable, as long as none was."""
        return self._guard.why_none

    @property
    def last_stamp(self):
        """Stamp [s] of the newest message that could be read, also a jump; None before any."""
        return self._guard.last_stamp

    @property
    def temperature(self):
        """Last known temperatures (n,) [degC], NaN where unknown."""
        return self._temperatures.values.copy()

    def joint_state(self, stamp, names, position, velocity, effort):
        """Return a MotionSample when one is due, else None."""
        accepted = self._guard.accept(stamp, names, position, velocity, effort)
        if accepted is None:
            return None
        if self._guard.restarted:
            self._filter.restart()
        if self._guard.some_velocity_stuck:
            # The filter knows all velocities or none.
            accepted[1] = math.nan
        if self._guard.turns is not None:
            accepted[0] += self._guard.turns
        if self._commands is not None:
            accepted = self._as_followed(stamp, accepted)
        self.accepted, self.arms = self.accepted + 1, len(self._guard.names.used)
        self._temperatures.expire(stamp, self._guard.names)
        gaps = self._filter.gaps
        sample = self._filter.update(stamp, *accepted)
        if self._filter.gaps > gaps:
            self._guard.rejected['gap'] += 1
        return sample

    def _as_followed(self, stamp, commanded):
        if self._guard.restarted:
            self._commands.restart()
        return self._commands.update(stamp, commanded)

    def use(self, robot):
        """Go on with the limits of another robot file of the same arm."""
        self._guard.use(robot)

    def temperature_reading(self, joint, celsius):
        """Note one joint's temperature; other names are passed over, broken values counted."""
        self._temperatures.take(joint, celsius, self._guard.names)


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
    """Return (Motion, rejected counts) of a Recording; RecordingError for one of two arms."""
    stream = JointStream(robot)
    samples = list(motion_samples(stream, recording))
    refuse_several(stream.names, recording.path)
    return Motion.of(samples), dict(stream.rejected)
