"""Which of the joint states that arrive are of this arm, told by the names of their joints."""

import numpy as np

from ..errors import RecordingError
from .heard_joints import HeardJoints

# Orders of names remembered; a driver that invents names must not fill the memory.
_MOST_ORDERS, _MOST_ARMS = 100, 10
_NEW = object()
# An arm that was not heard with its prefix for so long [s] may have got another.
SILENT = 2.0


class ArmNames:
    """
    Find the joints of one arm by name, in any order, also behind a tf_prefix.

    Arms alike may share a topic, each with a prefix of its own in messages of its own: this one
    keeps the prefix it was heard with first, until its joints are heard by their own names, or
    never again but with another. prefix: what it is heard with, or None; used: prefixes (list) it
    was heard with so far; others: prefixes of other arms; together: those of arms that one
    message has; passed_over: joint states of other joints, or arms.
    """

    def __init__(self, joints):
        self._joints, self._places, self._heard = joints, {}, HeardJoints(joints)
        self.used, self.others, self.together, self.passed_over = [], set(), set(), 0
        # Stamp of the newest of this arm; prefixes heard since then, another arm's or its own now.
        self._last, self._instead = None, set()

    @property
    def prefix(self):
        """What stands before this arm's joints in the joint states, None before any."""
        return self.used[-1] if self.used else None

    def why_none(self, rejected):
        """Return in words why no joint state was usable; rejected: reason -> count."""
        told = self._heard.why_none(rejected)
        return f'{told}; a message {_told_of(self.together)}' if self.together else told

    def index(self, names, stamp, whole=True):
        """
        Return where the joints stand among the names of a message of a stamp [s].

        Indices (n,), a reason to reject, or None when it is another arm's or of other joints.
        whole: whether it has a position and an effort of each; without, it tells of no prefix.
        """
        key = tuple(names)
        found = self._places.get(key, _NEW)
        if found is _NEW:
            found = self._note(key)
        index, prefix = found
        if prefix is not None and not (self._is_own(prefix, stamp) if whole
                                       else self.prefix in (None, prefix)):
            index = None
        if index is None:
            self.passed_over += 1
        return index

    def _is_own(self, prefix, stamp):
        """Tell whether it is this arm that is heard with a prefix at a stamp [s]."""
        if self.used and prefix != self.used[-1]:
            silent = self._last <= stamp - SILENT
            if stamp < self._last:
                self._last = stamp    # The clock was set back.
            # Its own names win; another arm is heard while this one is.
            if prefix and (prefix in self.others or not silent):
                if len(self._instead) < _MOST_ARMS:
                    self._instead.add(prefix)
                return False
            self.others.add(self.used[-1])
        if not self.used or prefix != self.used[-1]:
            self.used.append(prefix)
            self.others.discard(prefix)
        elif self._instead:
            if len(self.others) < _MOST_ORDERS:
                self.others |= self._instead
            self._instead.clear()
        self._last = stamp
        return True

    def _note(self, names):
        """Return places() of a new order of names, and remember it."""
        if len(self._places) >= _MOST_ORDERS:
            self._places.clear()
        self._places[names] = found = places(names, self._joints)
        self._heard.note(names, found[0])
        if isinstance(found[0], str) and len(self.together) < _MOST_ARMS:
            several = complete_prefixes(names, self._joints)
            self.together |= set(several) if len(several) > 1 else set()
        return found


def refuse_several(arm, name):
    """Raise RecordingError where a recording of a name has arms alike; arm: the ArmNames of it."""
    if arm.together or len(arm.used) > 1 or arm.prefix and arm.others:
        raise RecordingError(f'{name}: {_told_of(arm.together.union(arm.used, arm.others))}')


def _told_of(prefixes):
    """Return in words that arms with these prefixes were heard, and what to do."""
    told = ', '.join(map(repr, sorted(prefixes)))
    return (f'has joint states of more arms than one, behind {told}; name the joints in the robot '
            'file with the prefix of one of them')


def places(names, joints):
    """
    Return where joints stand among names, and their prefix there.

    Indices (n,), a reason to reject, or None when no joint is among them; the prefix is None
    without indices.
    """
    index, complete = {name: i for i, name in enumerate(names)}, complete_prefixes(names, joints)
    if complete is None:
        return None, None
    if len(complete) != 1 or any(list(names).count(complete[0] + j) > 1 for j in joints):
        return 'ambiguous_joint' if complete else 'missing_joint', None
    return np.array([index[complete[0] + joint] for joint in joints]), complete[0]


def complete_prefixes(names, joints):
    """
    Return the prefixes [sorted] with which names have all joints; None where they have none.

    Joints by their own names leave no other.
    """
    index = set(names)
    prefixes = [''] if any(joint in index for joint in joints) else sorted(
        {name[:-len(joint)] for name in names for joint in joints if name.endswith(joint)})
    return [p for p in prefixes if all(p + joint in index for joint in joints)] \
        if prefixes else None
