"""Temperatures of joints by name, for as long as a reading says something."""

from collections import Counter

import numpy as np

# What a joint of a robot can have [degC]; outside is a broken sensor or another unit.
PLAUSIBLE_TEMPERATURE = (-40.0, 150.0)
# A reading older than this [s] says nothing any more: joints warm over minutes.
TEMPERATURE_LIFE = 30.0
# Exactly zero is a driver's word for none, unless the joint has just been so near [K] to it.
NEAR_ZERO = 5.0
# Names remembered of others; a driver that invents names must not fill the memory.
_MOST_NAMES = 50


def joint_index(name, joints):
    """Return which of the joints a name means, also behind a tf_prefix; None if not just one."""
    if name in joints:
        return joints.index(name)
    matches = [i for i, joint in enumerate(joints) if name.endswith(joint)]
    return matches[0] if len(matches) == 1 else None


class TemperatureNames:
    """
    Which joint a temperature is of, where other arms' joints have the same names behind a prefix.

    The prefix of the joint states tells, or else a joint's own name; of other names a joint keeps
    the first that told of it.
    """

    def __init__(self, joints):
        self._joints, self._name_of, self._others = joints, {}, set()

    @property
    def names(self):
        """The names (list) that temperatures are taken from, and others alike that are not."""
        used = sorted(self._name_of.values())
        return used, sorted(self._others - set(used))

    def index(self, name, arm):
        """Return the joint's index, or None; arm: the ArmNames of the joint states."""
        index = joint_index(name, self._joints)
        if index is None or name[:-len(self._joints[index])] in arm.others:
            return None
        known = self._name_of.get(index, name)
        if self._rank(name, index, arm.prefix) > self._rank(known, index, arm.prefix):
            known = name
        self._name_of[index] = known
        if known != name and len(self._others) < _MOST_NAMES:
            self._others.add(name)
        return index if known == name else None

    def _rank(self, name, index, prefix):
        own = self._joints[index]
        return 2 * (prefix is not None and name == prefix + own) + (name == own)


class JointTemperatures:
    """
    Last readings of the joints.

    values (n,) [degC], NaN where unknown, too old, or from before the arm got another prefix;
    rejected: reason -> count. Time is told by expire(); a reading before the first of them starts
    with it.
    """

    def __init__(self, joints):
        self._names, self._arms = TemperatureNames(joints), 0
        self.values, self.rejected = np.full(len(joints), np.nan), Counter()
        self._read_at, self._now = np.full(len(joints), -np.inf), None
        # No reading expires before this: joint states come too often to look at all of them.
        self._none_expires_before = -np.inf

    @property
    def names(self):
        """The names (list) that temperatures are taken from, and others alike that are not."""
        return self._names.names

    def take(self, name, celsius, arm):
        """
        Note one joint's temperature; other names are passed over, broken values counted.

        arm: the ArmNames of the joint states.
        """
        self._follow(arm)
        index = self._names.index(name, arm)
        if index is None:
            return
        low, high = PLAUSIBLE_TEMPERATURE
        # NaN is within nothing.
        if not low < celsius < high:
            self.rejected['implausible_temperature'] += 1
            return
        if celsius == 0.0 and not abs(self.values[index]) < NEAR_ZERO:
            self.rejected['zero_temperature'] += 1
            return
        self.values[index] = celsius
        self._read_at[index] = np.nan if self._now is None else self._now
        expires = -np.inf if self._now is None else self._now + TEMPERATURE_LIFE
        self._none_expires_before = min(self._none_expires_before, expires)

    def _follow(self, arm):
        """Forget all readings where the joint states have got another prefix."""
        if 0 < self._arms < len(arm.used):
            self.values[:], self._read_at[:] = np.nan, -np.inf
        self._arms = len(arm.used)

    def expire(self, now, arm):
        """
        Forget what was read too long before `now` [s], or of another arm.

        arm: the ArmNames of the joint states.
        """
        self._follow(arm)
        if self._now is not None and now < self._now:
            # The clock has gone back: what was read before lives from now on.
            self._read_at = np.minimum(self._read_at, now)
            self._none_expires_before = -np.inf
        self._now = now
        if now <= self._none_expires_before:
            return
        self._read_at[np.isnan(self._read_at)] = now
        old = now - self._read_at > TEMPERATURE_LIFE
        self.rejected.update(['temperature_expired'] * int(np.isfinite(self.values[old]).sum()))
        self.values[old], self._read_at[old] = np.nan, -np.inf
        known = self._read_at[self._read_at > -np.inf]
        self._none_expires_before = min(known, default=now) + TEMPERATURE_LIFE
