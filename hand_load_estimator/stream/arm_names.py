"""Which of the joint states that arrive are of this arm, told by the names of their joints."""

import numpy as np

from ..errors import RecordingError
from .heard_joints import HeardJoints

# Orders of names remembered; a driver that invents names must not fill the memory.
_MOST_ORDERS = 100
_NEW = object()


class ArmNames:
    """
    Find the joints of one arm by name, in any order, also behind a tf_prefix.

    Arms alike may share a topic, each with a prefix of its own: this one keeps the prefix it was
    heard with first, until its joints are heard by their own names. prefix: what it is heard with,
    or None; others: prefixes of other arms; passed_over: joint states of other joints, or arms.
    """

    def __init__(self, joints):
        self._joints, self._places, self._heard = joints, {}, HeardJoints(joints)
        self.prefix, self.others, self.passed_over = None, set(), 0

    def why_none(self, rejected):
        """Return in words why no joint state was usable; rejected: reason -> count."""
        return self._heard.why_none(rejected)

    def index(self, names):
        """
        Return where the joints stand among the names of a message.

        Indices (n,), a reason to reject, or None when it is another arm's or of other joints.
        """
        key = tuple(names)
        found = self._places.get(key, _NEW)
        if found is _NEW:
            found = self._note(key)
        index, prefix = found
        if prefix != self.prefix and index is not None and not isinstance(index, str):
            index = self._of_another(index, prefix)
        if index is None:
            self.passed_over += 1
        return index

    def _of_another(self, index, prefix):
        """Return the indices if it is this arm that is heard with a prefix, None if another."""
        if self.prefix is None or not prefix:
            self.others |= {self.prefix} - {None}
            self.prefix = prefix
            return index
        if len(self.others) < _MOST_ORDERS:
            self.others.add(prefix)
        return None

    def _note(self, names):
        """Return places() of a new order of names, and remember it."""
        if len(self._places) >= _MOST_ORDERS:
            self._places.clear()
        self._places[names] = found = places(names, self._joints)
        self._heard.note(names, found[0])
        return found


def refuse_several(arms, name):
    """Raise RecordingError where a recording of a name has arms alike; arms: of JointStream."""
    prefix, others = arms
    if prefix and others:
        told = ', '.join(map(repr, sorted({prefix, *others})))
        raise RecordingError(f'{name}: has joint states of more arms than one, behind {told}; '
                             'name the joints in the robot file with the prefix of one of them')


def places(names, joints):
    """
    Return where joints stand among names, and their prefix there.

    Indices (n,), a reason to reject, or None when no joint is among them; the prefix is None
    without indices.
    """
    index = {name: i for i, name in enumerate(names)}
    prefixes = [''] if any(joint in index for joint in joints) else sorted(
        {name[:-len(joint)] for name in names for joint in joints if name.endswith(joint)})
    if not prefixes:
        return None, None
    complete = [p for p in prefixes if all(p + joint in index for joint in joints)]
    if len(complete) != 1 or any(list(names).count(complete[0] + j) > 1 for j in joints):
        return 'ambiguous_joint' if complete else 'missing_joint', None
    return np.array([index[complete[0] + joint] for joint in joints]), complete[0]
