"""Let only usable joint states through: by name, finite, forward in time; count the rest by kind."""

from collections import Counter

import numpy as np

# A backward step at least this long is a restarted clock or a looped recording, not jitter.
RESTART_AFTER = 0.5
# Faster than this many times the robot's limit is a broken message, not a motion.
SPEED_MARGIN = 5.0


class InputGuard:
    """
    Map messages to arrays in the robot's joint order and reject what cannot be used.

    rejected: reason -> count. Joints are found by name in any order, also behind a tf_prefix;
    messages about other joints only (a gripper's) are passed over and not counted as bad.
    """

    def __init__(self, joints, max_velocity):
        self._joints = tuple(joints)
        self._speed_limit = SPEED_MARGIN * np.asarray(max_velocity, dtype=float)
        self._index_of = {}
        self.rejected = Counter()
        self.last_stamp = None
        self.restarted = False

    def accept(self, stamp, names, position, velocity, effort):
        """
        Return (q, v, effort), (n,) each, or None.

        v is NaN where the message has no velocity. `restarted` tells whether the clock jumped
        back before this message.
        """
        key = tuple(names)
        if key not in self._index_of:
            self._index_of[key] = self._find(key)
        index = self._index_of[key]
        if index is None:
            return None
        if isinstance(index, str):
            return self._reject(index)
        size = len(key)
        if len(position) != size or len(effort) != size or len(velocity) not in (0, size):
            return self._reject('short_arrays')
        q = np.asarray(position, dtype=float)[index]
        tau = np.asarray(effort, dtype=float)[index]
        v = np.asarray(velocity, dtype=float)[index] if len(velocity) else np.full(len(q), np.nan)
        if not (np.isfinite(q).all() and np.isfinite(tau).all() and np.isfinite(stamp)):
            return self._reject('not_finite')
        if len(velocity) and not np.isfinite(v).all():
            return self._reject('not_finite')
        if (np.abs(v) > self._speed_limit).any():
            return self._reject('implausible_velocity')
        return (q, v, tau) if self._forward(stamp) else None

    def _find(self, names):
        """Return indices (n,), a reason to reject, or None when no joint is of this robot."""
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
        if self.last_stamp is not None and stamp <= self.last_stamp:
            if self.last_stamp - stamp < RESTART_AFTER:
                self._reject('repeated_stamp' if stamp == self.last_stamp else 'backward_stamp')
                return False
            self.rejected['clock_restart'] += 1
            self.restarted = True
        self.last_stamp = stamp
        return True

    def _reject(self, reason):
        self.rejected[reason] += 1
        return None
