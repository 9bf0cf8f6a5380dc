"""Let only usable joint states through: by name, finite, forward in time; count the others."""

from collections import Counter
import math

import numpy as np

from .arm_names import ArmNames
from .continuity import Continuity
from .frozen import Frozen
from .velocities import Velocities

# A backward step at least this long is a restarted clock or a looped recording, not jitter.
RESTART_AFTER = 0.5
# More than this many times the robot's limit is a broken message, not a motion or a torque.
SPEED_MARGIN = 5.0
EFFORT_MARGIN = 3.0
# A joint without stops may count its turns on and on, but no further than this [rad].
ENDLESS = 1e6
# Closer stamps [s] than any joint state has are one stamp written twice.
SHORTEST_STEP = 1e-6


class InputGuard:
    """
    Map messages to arrays in the robot's joint order and reject what cannot be used.

    robot: names, limits, torque constants. rejected: reason -> count. Joints are found by name in
    any order, also behind a tf_prefix (arm_names.py); messages about other joints only (a
    gripper's) are not bad: they are counted apart, in passed_over. names: the ArmNames; last_stamp
    [s]: of the newest that could be read, also a jump; None before any.
    """

    def __init__(self, robot):
        self.names = ArmNames(robot.joints)
        self._course = Continuity(SPEED_MARGIN * robot.limits.velocity, robot.turning)
        self._velocities, self._frozen = Velocities(len(robot.joints)), Frozen()
        self._has_velocities = False
        self.rejected, self.last_stamp = Counter(), None
        self.use(robot)

    def use(self, robot):
        """Go on with the limits of another robot file of the same arm."""
        limits = robot.limits
        speed = SPEED_MARGIN * limits.velocity
        self._course.speed_limit = speed
        effort = EFFORT_MARGIN * limits.torque / np.abs(robot.effort.torque_constants)
        # A turn beyond the stops is an encoder that counts on, more is not an angle.
        stops = np.clip(robot.stops, -ENDLESS, ENDLESS) + 2.0 * np.pi * np.array([[-1.0], [1.0]])
        self._least = np.array([stops[0], -speed, -effort])
        self._most = np.array([stops[1], speed, effort])

    @property
    def restarted(self):
        """Whether the clock or the arm jumped before the last message that passed."""
        return self._course.restarted

    @property
    def turns(self):
        """Whole turns (n,) [rad] that the arm is ahead of what is reported, or None."""
        return self._course.turns

    @property
    def passed_over(self):
        """Number of joint states of other joints, or of another arm."""
        return self.names.passed_over

    @property
    def why_none(self):
        """In words why no joint state was usable, as long as none was."""
        return self.names.why_none(self.rejected)

    @property
    def frozen(self):
        """For how long [s] joint states have been the same to the last bit."""
        return self._frozen.seconds

    @property
    def velocity_stuck(self):
        """Which joints' (n,) velocities are zero while they move, and count as missing."""
        return self._velocities.stuck

    @property
    def some_velocity_stuck(self):
        """Whether there is such a joint."""
        return self._velocities.some

    def accept(self, stamp, names, position, velocity, effort):
        """
        Return (3, n): q, v, effort, or None.

        v is NaN where the message has no velocity, or NaN as ros2_control fills in where a joint
        has no such interface (all are done without, then, unless all have been measured before),
        or is always zero (velocities.py). q is as reported;
        `turns` is what it has been turned on beyond that. `restarted` tells whether the clock or
        the arm jumped before this message.
        """
        before, size = self.names.prefix, len(names)
        whole = len(position) == len(effort) == size and len(velocity) in (0, size)
        index = self.names.index(names, stamp, whole)
        if self.names.prefix != before:
            self._course.forget()
            self._has_velocities = False
        if index is None:
            return None
        if isinstance(index, str):
            return self._reject(index)
        if not whole:
            return self._reject('short_arrays')
        signal = np.array((position, velocity if len(velocity) else effort, effort),
                          dtype=float).take(index, 1)
        # One look at everything: this runs a thousand times a second, where all() and any() cost
        # as much again as what they look at. NaN is within nothing.
        within = (signal >= self._least) & (signal <= self._most)
        if not len(velocity) or (math.isnan(signal[1, 0]) and np.isnan(signal[1]).all()) or (
                not self._has_velocities and np.isnan(signal[1]).any()):
            signal[1], within[1] = np.nan, True
        if np.count_nonzero(within) < within.size or not math.isfinite(stamp):
            return self._reject(self._fault(stamp, signal, within))
        if not self._forward(stamp):
            return None
        self._has_velocities = self._has_velocities or not math.isnan(signal[1, 0])
        self._frozen.look(stamp, signal)
        if not self._course.follow(stamp, signal[0]):
            return self._reject('position_jump')
        if self._course.restarted:
            self._velocities.forget()
        turns = self._course.turns
        return self._velocities.checked(stamp, signal, 0.0 if turns is None else turns)

    def _fault(self, stamp, signal, within):
        """Return why a signal (3, n) that is not within limits everywhere (3, n) is refused."""
        if not (np.isfinite(signal) | within).all() or not math.isfinite(stamp):
            return 'not_finite'
        _, speeds, efforts = within.all(axis=1)
        if not speeds:
            return 'implausible_velocity'
        return 'implausible_position' if efforts else 'implausible_effort'

    def _forward(self, stamp):
        if self.last_stamp is not None and stamp < self.last_stamp + SHORTEST_STEP:
            if self.last_stamp - stamp < RESTART_AFTER:
                near = abs(stamp - self.last_stamp) < SHORTEST_STEP
                self._reject('repeated_stamp' if near else 'backward_stamp')
                return False
            self.rejected['clock_restart'] += 1
            self._course.forget()
        self.last_stamp = stamp
        return True

    def _reject(self, reason):
        self.rejected[reason] += 1
        return None
