"""
Where a joint's reported effort stood at an end of its range: it tells less than acts there.

A current sensor that clips, a drive's limit that is reported instead of the torque: without those
rows the rest is as good as ever, with them everything else makes up for what is cut off.
"""

import numpy as np

from ..stream.arm_names import ArmNames
from ..stream.input_guard import EFFORT_MARGIN, RESTART_AFTER

# An end of the range, as a share of it; the share of the time in motion from which on efforts
# pile up there, and how many times more than just below: smooth efforts dwell at their largest,
# and coarse ones repeat it, but neither leaves it in one step.
END, OFTEN, STEP = 0.002, 0.02, 5.0
# Fewer efforts [share] are beyond an end by chance: single spikes.
SPIKES = 0.002
# The filter's memory [s] of what it was fed.
MEMORY = 0.1
# An effort that varies by no more than this share of max_torque does not change.
CONSTANT = 1e-9
MOVES = 0.02           # [rad/s]
LEAST = 1.0            # [s] of motion that tells an end from a joint that is held


def clipped_rows(robot, motion, recording):
    """Return (N, n) bool: rows of a Motion in which the effort of its Recording was cut off."""
    out = np.zeros(motion.effort.shape, bool)
    stamp, effort = _reported(robot, recording)
    passes = list(_passes(stamp, motion.stamp))
    speed = np.zeros(effort.shape)
    for said, rows in passes:
        for j in range(robot.n):
            speed[said, j] = np.interp(stamp[said], motion.stamp[rows], np.abs(motion.v[rows, j]))
    for j in range(robot.n):
        for side in (effort[:, j], -effort[:, j]):
            at_end = cut_off(side, speed[:, j] > MOVES, stamp)
            for said, rows in passes if at_end.any() else ():
                out[rows, j] |= _remembered(motion.stamp[rows], stamp[said][at_end[said]])
    return out


def never_changes(robot, torque):
    """Tell which columns (n,) of efforts as torque (N, n) [Nm] are one value all the time."""
    return np.ptp(torque, axis=0) <= CONSTANT * robot.limits.torque


def cut_off(effort, moves, stamp):
    """
    Tell which efforts (M,) stand at the upper end of their range, none where it is no end.

    moves (M,) bool: while the joint moves; stamp (M,) [s].
    """
    none = np.zeros(len(effort), bool)
    if moves.sum() < 2 or moves.sum() * np.median(np.abs(np.diff(stamp))) < LEAST:
        return none
    top = np.quantile(effort[moves], 1.0 - SPIKES)
    at_end = effort >= (1.0 - END) * top
    below = effort[moves & ~at_end]
    if top <= 0.0 or not len(below):
        return none
    near = (below >= below.max() - END * top).sum()
    piled = (at_end & moves).sum()
    return at_end if piled > max(OFTEN * moves.sum(), STEP * near) else none


def clipped_efforts(robot, evidence):
    """Return a sentence for each joint whose effort was cut off in a recording."""
    shares = ((e.name, joint, share) for e in evidence
              for joint, share in zip(robot.joints, 1.0 - e.tells.mean(axis=0)))
    return [f'{name}: the effort of {joint} stands at an end of its range again and again; '
            f'{100.0 * share:.0f} % of its samples are left out'
            for name, joint, share in shares if share > 0.0]


def _passes(said, moved):
    """Yield (slice of `said`, slice of `moved`) between restarts of the clock, stamps [s] both."""
    cuts = [[0, *np.flatnonzero(np.diff(stamps) < -RESTART_AFTER) + 1, len(stamps)]
            for stamps in (said, moved)]
    # A pass that is too short for the filter has no rows, and nobody knows whose the others are.
    if len(cuts[0]) == len(cuts[1]) and len(said) and len(moved):
        for a, b, c, d in zip(cuts[0], cuts[0][1:], cuts[1], cuts[1][1:]):
            yield slice(a, b), slice(c, d)


def _reported(robot, recording):
    """Return stamps (M,) and efforts (M, n) of the joint states that have them all."""
    names, stamps, efforts = ArmNames(robot.joints), [], []
    for state in recording.joint_samples:
        told = len(state.effort) == len(state.names)
        order = names.index(state.names, state.stamp, told)
        if told and isinstance(order, np.ndarray):
            stamps.append(state.stamp)
            efforts.append(np.asarray(state.effort)[order])
    efforts = np.array(efforts, dtype=float).reshape(-1, robot.n)
    # What the guard rejects is no end of a range.
    most = EFFORT_MARGIN * robot.limits.torque / np.abs(robot.effort.torque_constants)
    usable = (np.abs(efforts) <= most).all(axis=1)
    return np.array(stamps)[usable], efforts[usable]


def _remembered(times, clipped):
    """Tell which times (N,) [s] are within the filter's memory of clipped ones (M,) [s]."""
    clipped = np.sort(clipped)
    before = np.searchsorted(clipped, times, side='right') - 1
    return (before >= 0) & (times - clipped[before] <= MEMORY) if len(clipped) \
        else np.zeros(len(times), bool)
