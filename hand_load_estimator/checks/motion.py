"""Is the position plausible, does the velocity belong to it, does every joint move."""

import numpy as np

from .finding import DOUBT, Finding, OK, UNKNOWN, WRONG
from .signals import low_pass

# [rad/s] a joint below it counts as standing.
STANDING = 0.01
_COMPARED_BELOW = 5.0


def check_values(recording, position, velocity, effort):
    """Return the finding about missing, short and non-finite values."""
    missing = np.isnan(velocity)
    # As input_guard.py has it: all are done without where one was never measured.
    never = ~np.logical_or.accumulate(np.isfinite(velocity).all(axis=1))
    absent = missing.all(axis=1) | (missing.any(axis=1) & never)
    counts = {what: int(np.sum(~np.isfinite(values).all(axis=1) & used))
              for what, values, used in (('position', position, True),
                                         ('velocity', velocity, ~absent),
                                         ('effort', effort, True))}
    short = sum(len(s.position) != len(s.names) or len(s.effort) != len(s.names)
                or len(s.velocity) not in (0, len(s.names)) for s in recording.joint_samples)
    text = ', '.join(f'{n} without a usable {what}' for what, n in counts.items() if n)
    if not text and not short:
        return Finding('values', OK, f'{"position and effort" if absent.any() else "all"} finite')
    share = max(counts.values()) / len(position)
    return Finding('values', WRONG if share > 0.5 else DOUBT,
                   f'of {len(position)} messages: {text or "none"}; {short} with short arrays',
                   'such messages are rejected and counted; the velocity of all joints may be '
                   'missing, or of one from the first message on, position and effort may not')


# Messages from one that moves to the next, of a driver that repeats itself; more is a rest.
_FEW = 12


def check_updates(position, velocity, effort):
    """Return the finding about messages that repeat the state of the one before while moving."""
    moves = np.abs(np.diff(position, axis=0)).max(axis=1) > 0.0
    whole = np.hstack([position, np.nan_to_num(velocity), np.nan_to_num(effort)])
    repeats = (np.diff(whole, axis=0) == 0.0).all(axis=1)
    # A repeat counts only shortly between messages that move: a standing arm is no fault.
    moved = np.flatnonzero(moves)
    after = np.searchsorted(moved, np.arange(len(moves)))
    edges = np.concatenate([[-np.inf], moved, [np.inf]])
    there = moves | (edges[after + 1] - edges[after] <= _FEW)
    share = np.mean(repeats[there]) if there.any() else 0.0
    text = f'{100.0 * share:.1f} % of the messages in motion repeat the one before'
    return Finding('updates', OK if share < 0.02 else DOUBT, text, '' if share < 0.02 else
                   'the publisher is faster than the robot or not in step with it; publish at '
                   'the robot\'s own rate')


def check_position(position, robot):
    """Return the finding about position range and unit."""
    lower, upper = robot.limits.lower, robot.limits.upper
    low, high = np.nanmin(position, axis=0), np.nanmax(position, axis=0)
    beyond = np.maximum(lower - low, high - upper)
    worst_joint = int(np.argmax(beyond))
    text = (f'{robot.joints[worst_joint]} reaches {low[worst_joint]:.3f} to '
            f'{high[worst_joint]:.3f}, limits {lower[worst_joint]:.3f} to '
            f'{upper[worst_joint]:.3f} rad')
    if np.max(high - low) > 6.0 * np.pi:
        return Finding('position', WRONG, text, 'looks like degrees; JointState wants rad')
    if beyond[worst_joint] > 0.02:
        return Finding('position', DOUBT, text, 'compare the zero position and the limits of '
                       'the URDF with the robot')
    return Finding('position', OK, 'inside the limits of the URDF')


def moving(signals, slowest=STANDING):
    """Return which joints move (n,), faster than slowest [rad/s], for more than a second."""
    return np.sum(np.abs(signals.v) > slowest, axis=0) / signals.rate > 1.0


def check_motion(signals, robot):
    """Return the finding about how much each joint moves."""
    moves = moving(signals)
    peak = np.max(np.abs(signals.v), axis=0)
    text = 'peak speed ' + ' '.join(f'{p:.2f}' for p in peak) + ' rad/s'
    still = [name for name, m in zip(robot.joints, moves) if not m]
    if not still:
        return Finding('motion', OK, text)
    return Finding('motion', DOUBT if moves.any() else UNKNOWN,
                   f'{text}; standing: {", ".join(still)}',
                   'nothing can be said of the friction and gain of a standing joint; '
                   'record a motion of `hand_load excite`')


def _slope_and_lag(signals, j):
    """Return slope and lag [s] of the measured against the derived velocity of a joint."""
    measured = low_pass(signals.velocity[:, j], signals.rate, _COMPARED_BELOW)
    derived = low_pass(signals.v[:, j], signals.rate, _COMPARED_BELOW)
    acceleration = np.gradient(derived, 1.0 / signals.rate)
    # measured = slope * derived(t - lag), to first order in the lag
    columns = np.column_stack([derived, -acceleration, np.ones_like(derived)])
    solution, *_ = np.linalg.lstsq(columns, measured, rcond=None)
    return solution[0], solution[1] / solution[0] if abs(solution[0]) > 0.05 else 0.0


def check_velocity(signals, robot):
    """Return the finding about measured velocity against the derivative of the position."""
    moves = np.flatnonzero(moving(signals))
    never = ~np.isfinite(signals.velocity).any(axis=0)
    if never.any():
        whose = '' if never.all() else 'of ' + ', '.join(
            robot.joints[j] for j in np.flatnonzero(never)) + ' '
        return Finding('velocity', OK, f'{whose}not in the messages; all are derived from the '
                       'position')
    if not np.isfinite(signals.velocity).all():
        return Finding('velocity', DOUBT, 'missing in some messages', 'where it is missing for '
                       'all joints, or of one from the first message on, it is derived from the '
                       'position, other such messages are rejected')
    if not len(moves):
        return Finding('velocity', UNKNOWN, 'no joint moves')
    pairs = np.array([_slope_and_lag(signals, j) for j in moves])
    slopes, lags = pairs[:, 0], pairs[:, 1]
    text = (f'{np.min(slopes):.3f} to {np.max(slopes):.3f} times the derivative of the position, '
            f'late by {1e3 * np.min(lags):.1f} to {1e3 * np.max(lags):.1f} ms')
    wrong = np.abs(slopes - 1.0) > 0.2
    if wrong.any():
        names = ', '.join(robot.joints[j] for j in moves[wrong])
        return Finding('velocity', WRONG, f'{text} ({names})', 'compare sign and unit (rad/s) of '
                       'velocity and position')
    verdict = DOUBT if np.max(np.abs(slopes - 1.0)) > 0.05 or np.max(np.abs(lags)) > 0.02 else OK
    return Finding('velocity', verdict, text, '' if verdict == OK else
                   'the driver filters its velocity; the position is differentiated instead')
