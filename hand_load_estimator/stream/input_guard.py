"""Let only usable joint states through: by name, finite, forward in time; count the others."""

from collections import Counter
import math

import numpy as np

from .heard_joints import HeardJoints

# A backward step at least this long is a restarted clock or a looped recording, not jitter.
RESTART_AFTER = 0.5
# More than this many times the robot's limit is a broken message, not a motion or a torque.
SPEED_MARGIN = 5.0
EFFORT_MARGIN = 3.0
# A joint without stops may count its turns on and on, but no further than this [rad].
ENDLESS = 1e6
# Closer stamps [s] than any joint state has are one stamp written twice.
SHORTEST_STEP = 1e-6
# Orders of names remembered; a driver that invents names must not fill the memory.
_MOST_ORDERS = 100
_NEW = object()


class InputGuard:
    """
    Map messages to arrays in the robot's joint order and reject what cannot be used.

    robot: names, limits, torque constants. rejected: reason -> count. Joints are found by name in
    any order, also behind a tf_prefix; messages about other joints only (a gripper's) are not bad:
    they are counted apart, in passed_over.
    """

    def __init__(self, robot):
        self._joints, limits = robot.joints, robot.limits
        self._speed_limit = SPEED_MARGIN * limits.velocity
        effort = EFFORT_MARGIN * limits.torque / np.abs(robot.effort.torque_constants)
        # A turn beyond the stops is an encoder that counts on, more is not an angle.
        stops = np.clip(robot.stops, -ENDLESS, ENDLESS) + 2.0 * np.pi * np.array([[-1.0], [1.0]])
        self._least = np.array([stops[0], -self._speed_limit, -effort])
        self._most = np.array([stops[1], self._speed_limit, effort])
        self._last_position = None
        self._index_of, self._heard = {}, HeardJoints(robot.joints)
        self.rejected, self.passed_over = Counter(), 0
        self.last_stamp = None
        self.restarted = False

    @property
    def why_none(self):
        """In words why no joint state was usable, as long as none was."""
        return self._heard.why_none(self.rejected)

    def accept(self, stamp, names, position, velocity, effort):
        """
        Return (3, n): q, v, effort, or None.

        v is NaN where the message has no velocity, or only NaN as ros2_control fills in where a
        joint has no such interface. `restarted` tells whether the clock or the arm jumped before
        this message.
        """
        key = tuple(names)
        index = self._index_of.get(key, _NEW)
        if index is _NEW:
            index = self._note(key)
        if index is None:
            self.passed_over += 1
            return None
        if isinstance(index, str):
            return self._reject(index)
        size = len(key)
        if len(position) != size or len(effort) != size or len(velocity) not in (0, size):
            return self._reject('short_arrays')
        signal = np.array((position, velocity if len(velocity) else effort, effort),
                          dtype=float).take(index, 1)
        # One look at everything: this runs a thousand times a second, where all() and any() cost
        # as much again as what they look at. NaN is within nothing.
        within = (signal >= self._least) & (signal <= self._most)
        if not len(velocity) or (math.isnan(signal[1, 0]) and np.isnan(signal[1]).all()):
            signal[1], within[1] = np.nan, True
        if np.count_nonzero(within) < within.size or not math.isfinite(stamp):
            return self._reject(self._fault(stamp, signal, within))
        usable = self._forward(stamp) and self._continuous(stamp, signal[0])
        return signal if usable else None

    def _note(self, names):
        """Return places() of a new order of names, and remember it."""
        if len(self._index_of) >= _MOST_ORDERS:
            self._index_of.clear()
        self._index_of[names] = index = self.places(names)
        self._heard.note(names, index)
        return index

    def _fault(self, stamp, signal, within):
        """Return why a signal (3, n) that is not within limits everywhere (3, n) is refused."""
        if not (np.isfinite(signal) | within).all() or not math.isfinite(stamp):
            return 'not_finite'
        _, speeds, efforts = within.all(axis=1)
        if not speeds:
            return 'implausible_velocity'
        return 'implausible_position' if efforts else 'implausible_effort'

    def places(self, names):
        """
        Return where the joints stand among the names of a message.

        Indices (n,), a reason to reject, or None when no joint is of this robot.
        """
        index = {name: i for i, name in enumerate(names)}
        prefixes = [''] if any(joint in index for joint in self._joints) else sorted(
            {name[:-len(joint)] for name in names for joint in self._joints
             if name.endswith(joint)})
        if not prefixes:
            return None
        complete = [p for p in prefixes if all(p + joint in index for joint in self._joints)]
        if len(complete) != 1 or any(list(names).count(complete[0] + j) > 1 for j in self._joints):
            return 'ambiguous_joint' if complete else 'missing_joint'
        return np.array([index[complete[0] + joint] for joint in self._joints])

    def _forward(self, stamp):
        self.restarted = False
        if self.last_stamp is not None and stamp < self.last_stamp + SHORTEST_STEP:
            if self.last_stamp - stamp < RESTART_AFTER:
                near = abs(stamp - self.last_stamp) < SHORTEST_STEP
                self._reject('repeated_stamp' if near else 'backward_stamp')
                return False
            self.rejected['clock_restart'] += 1
            self.restarted = True
            self._last_position = None
        return True

    def _continuous(self, stamp, q):
        """Note an accepted state; refuse one that is farther away than the arm can have gone."""
        if self._last_position is None:
            # After a jump or a restarted clock the motion has no past.
            self.restarted = True
        else:
            # The second term lets encoders quantise and clocks jitter.
            reach = self._speed_limit * (stamp - self.last_stamp) + 0.02
            if np.count_nonzero(np.abs(q - self._last_position) > reach):
                self._last_position, self.last_stamp = None, stamp
                return bool(self._reject('position_jump'))
        self._last_position, self.last_stamp = q, stamp
        return True

    def _reject(self, reason):
        self.rejected[reason] += 1
        return None
