"""
Where a joint's reported effort stood at an end of its range: it tells less than acts there.

A current sensor that clips, a drive's limit that is reported instead of the torque: without those
rows the rest is as good as ever, with them everything else makes up for what is cut off.
"""

import numpy as np

from .input_guard import EFFORT_MARGIN
from .joint_stream import joint_index

# An end of the range, as a share of it; the share of the time in motion from which on efforts
# pile up there, and how many times more than just below: smooth efforts dwell at their largest,
# and coarse ones repeat it, but neither leaves it in one step.
END, OFTEN, STEP = 0.002, 0.02, 5.0
# The filter's memory [s] of what it was fed.
MEMORY = 0.1
MOVES = 0.02           # [rad/s]


def clipped_rows(robot, motion, recording):
    """Return (N, n) bool: rows of a Motion in which the effort of its Recording was cut off."""
    out = np.zeros(motion.effort.shape, bool)
    stamp, effort = _reported(robot, recording)
    for j in range(robot.n):
        speed = np.abs(np.interp(stamp, motion.stamp, motion.v[:, j]))
        moves = speed > MOVES
        for side in (effort[:, j], -effort[:, j]):
            at_end = _cut_off(side, moves)
            if at_end.any():
                out[:, j] |= _remembered(motion.stamp, stamp[at_end])
    return out


def _cut_off(effort, moves):
    """Tell which efforts (M,) stand at the upper end of their range, none where it is no end."""
    none = np.zeros(len(effort), bool)
    top = effort[moves].max(initial=0.0)
    if top <= 0.0:
        return none
    at_end = effort >= (1.0 - END) * top
    below = effort[moves & ~at_end]
    beside = below.max(initial=-np.inf)
    near = (below >= beside - END * top).sum()
    piled = (at_end & moves).sum()
    return at_end if piled > max(OFTEN * moves.sum(), STEP * near) else none


def clipped_efforts(robot, evidence):
    """Return a sentence for each joint whose effort was cut off in a recording."""
    shares = ((e.name, joint, share) for e in evidence
              for joint, share in zip(robot.joints, 1.0 - e.tells.mean(axis=0)))
    return [f'{name}: the effort of {joint} stands at an end of its range again and again; '
            f'{100.0 * share:.0f} % of its samples are left out'
            for name, joint, share in shares if share > 0.0]


def _reported(robot, recording):
    """Return stamps (M,) and efforts (M, n) of the joint states that have them all."""
    orders, stamps, efforts = {}, [], []
    for state in recording.joint_samples:
        if state.names not in orders:
            orders[state.names] = _order(robot.joints, state.names)
        order = orders[state.names]
        if order is not None and len(state.effort) == len(state.names):
            stamps.append(state.stamp)
            efforts.append(np.asarray(state.effort)[order])
    efforts = np.array(efforts, dtype=float).reshape(-1, robot.n)
    # What the guard rejects is no end of a range.
    most = EFFORT_MARGIN * robot.limits.torque / np.abs(robot.effort.torque_constants)
    usable = (np.abs(efforts) <= most).all(axis=1)
    return np.array(stamps)[usable], efforts[usable]


def _order(joints, names):
    """Return the place (n,) of each joint among the names of a message, None without them all."""
    places = {joint_index(name, joints): k for k, name in enumerate(names)}
    return [places[j] for j in range(len(joints))] if set(range(len(joints))) <= set(places) \
        else None


def _remembered(times, clipped):
    """Tell which times (N,) [s] are within the filter's memory of clipped ones (M,) [s]."""
    clipped = np.sort(clipped)
    before = np.searchsorted(clipped, times, side='right') - 1
    return (before >= 0) & (times - clipped[before] <= MEMORY)
