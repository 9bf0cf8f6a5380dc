"""Does the effort stay within max_torque, or stand at an end of its range and tell nothing."""

import numpy as np

from ..identification.clipped_effort import cut_off, MOVES, never_changes
from .finding import DOUBT, Finding, OK, WRONG
from .motion import moving


def check_range(signals, robot):
    """Return findings, and the indices of moving joints whose effort is not what acts there."""
    dead = np.flatnonzero(moving(signals) & never_changes(robot, signals.effort))
    shares = {j: _share_cut_off(signals, j) for j in range(robot.n) if j not in dead}
    cut = {j: share for j, share in shares.items() if share > 0.0}
    findings = [_dead(signals, robot, dead)] if len(dead) else []
    return [*findings, _saturation(signals, robot, cut)], {*dead, *cut}


def _share_cut_off(signals, j):
    """Return the share of the time in which a joint's effort stands at an end of its range."""
    effort, moves = signals.effort[:, j], np.abs(signals.v[:, j]) > MOVES
    upper, lower = (cut_off(side, moves, signals.time) for side in (effort, -effort))
    return float(np.mean(upper | lower))


def _dead(signals, robot, dead):
    told = ', '.join(f'{robot.joints[j]} stays at {signals.effort[0, j]:.4g} Nm' for j in dead)
    return Finding('effort', WRONG, f'never changes while its joint moves: {told}',
                   'have the driver publish what it measures, in a range that holds it')


def _saturation(signals, robot, cut):
    share = np.max(np.abs(signals.effort), axis=0) / robot.limits.torque
    j = int(np.argmax(share))
    text = f'largest on {robot.joints[j]}: {100.0 * share[j]:.0f} % of max_torque'
    if cut:
        told = ', '.join(f'{robot.joints[k]} at {np.max(np.abs(signals.effort[:, k])):.4g} Nm '
                         f'{100.0 * often:.0f} % of the time' for k, often in cut.items())
        return Finding('saturation', DOUBT, f'{text}; cut off: {told}; nothing else is said of '
                       'them', 'look for the limit in sensor or driver, or move slower and with '
                       'less load')
    at_end = np.mean(np.abs(signals.effort[:, j]) > 0.98 * robot.limits.torque[j])
    if share[j] > 1.2:
        return Finding('saturation', DOUBT, text, 'compare max_torque and the unit of the effort')
    if at_end > 0.002:
        return Finding('saturation', DOUBT, f'{text}, {100.0 * at_end:.1f} % of the time',
                       'move slower or with less load')
    return Finding('saturation', OK, text)
