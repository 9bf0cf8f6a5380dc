"""Recordings made ready for identification: motion, and torque less a known load's."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..errors import RecordingError
from ..files.recording_mark import content_of, message_digests, RecordingMark
from ..load import LoadParameters
from ..torque.columns import real_torque
from ..torque.shown_links import shown_links
from .clipped_effort import clipped_rows
from .temperature_gaps import bridged


# Rows further apart than their dt by this [s] have a gap between; parts shorter than that [s]
# tell nothing.
GAP, SHORTEST = 0.1, 0.5


@dataclass(frozen=True)
class Evidence:
    """
    One recording made ready, or a part of it: name of the recording, Motion, torque less the known
    load's (N, n) [Nm].

    load: LoadParameters declared, which drives and gears carry all the same; messages (M,)
    uint64: of the whole recording, as of recording_mark.message_digests, none where it is not on
    disk; rejected {reason: count}: input of the whole recording that was not used; clipped (N, n)
    bool: rows whose effort was cut off, or None where that is not known.
    """

    name: str
    motion: object
    torque: np.ndarray
    load: LoadParameters = field(default_factory=LoadParameters)
    messages: np.ndarray = field(default_factory=lambda: np.empty(0, np.uint64))
    rejected: dict = field(default_factory=dict)
    clipped: np.ndarray | None = None

    @property
    def tells(self):
        """Rows (N, n) bool whose torque is that of the joint."""
        return np.ones(self.torque.shape, bool) if self.clipped is None else ~self.clipped

    def part(self, rows):
        """Return the Evidence of some rows."""
        return replace(self, motion=self.motion.part(rows), torque=self.torque[rows],
                       clipped=None if self.clipped is None else self.clipped[rows])

    @cached_property
    def mark(self):
        """The RecordingMark of the recording."""
        return RecordingMark(self.name, content_of(self.messages))


def recording_numbers(evidence):
    """Return for each Evidence the number of its recording: parts of one have its mark."""
    marks = list(dict.fromkeys(e.mark for e in evidence))
    return [marks.index(e.mark) for e in evidence]


def between_gaps(evidence):
    """
    Return a list of Evidence cut where joint states are missing: motion has no past there.

    Parts too short to be worth it are left out, but never all of a recording.
    """
    out = []
    for own in evidence:
        motion = own.motion
        gaps = np.flatnonzero(np.abs(np.diff(motion.stamp) - motion.dt[1:]) > GAP) + 1
        parts = np.split(np.arange(len(motion.stamp)), gaps)
        longest = max(map(len, parts))
        out += [own] if len(parts) == 1 else [
            own.part(rows) for rows in parts
            if len(rows) == longest or motion.dt[rows].sum() >= SHORTEST]
    return out


def prepare(robot, name, motion, load, recording=None, rejected=None):
    """
    Return the Evidence of a Motion with the given LoadParameters.

    recording: the Recording it comes from, and rejected {reason: count}, or None.
    """
    rejected = rejected or {}
    if len(motion.stamp) == 0:
        raise RecordingError(f'{name}: {_why_empty(robot, recording, rejected)}')
    motion = bridged(motion)
    torque = np.array([real_torque(robot, q, e) for q, e in zip(motion.q, motion.effort)])
    if load.mass > 0.0:
        torque -= robot.load_columns(shown_links(robot, motion)) @ load.to_products()
    if recording is None:
        return Evidence(name, motion, torque, load, rejected=rejected)
    return Evidence(name, motion, torque, load, message_digests(recording), rejected,
                    clipped_rows(robot, motion, recording))


def _why_empty(robot, recording, rejected):
    """Return in words what the joint states lack of which none is usable."""
    states = recording.joint_samples if recording is not None else []
    if not states:
        return 'holds no usable joint states'
    foreign = not rejected or 'missing_joint' in rejected
    why = (f'their joints are {", ".join(states[0].names)}, those of the robot file '
           f'{", ".join(robot.joints)}' if foreign else
           ', '.join(f'{count} {reason.replace("_", " ")}' for reason, count in rejected.items()))
    return (f'holds no usable joint states among {len(states)}: {why}; give the robot file of '
            'this arm, and see `hand_load check`')
