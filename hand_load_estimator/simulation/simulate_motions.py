"""
Motions by name for `hand_load simulate` and the benchmark.

All stay inside the position, velocity and acceleration limits of the robot file, within REACH of
a middle pose, and inside the drives' torque with the rated load in the hand.
"""

import numpy as np

from ..errors import ConfigurationError
from ..motions.trajectory import concatenate, hold, Trajectory

REACH = 1.2              # [rad] from the middle pose
_MARGIN = 0.05           # [rad] from the position limits
_DWELL = (0.3, 1.0)      # [s]
_SHORTEST_MOVE = 0.3     # [s]
_LEAST_TRAVEL = 0.3      # [rad] of the joint that travels farthest
# Peaks of a quintic from rest to rest over distance 1 in time 1.
_QUINTIC_SPEED, _QUINTIC_ACCELERATION = 1.875, 5.7735
_FREQUENCIES = np.array([0.07, 0.13, 0.19, 0.29, 0.37, 0.47])  # [Hz]
_RAMP = 2.0              # [s] of a multi-sine from rest and back to it
_KNOT = 0.02             # [s]


def middle_pose(robot):
    """Return the pose (n,) motions keep around: zero, or mid-range for joints that cannot."""
    limits = robot.limits
    centre = 0.5 * (limits.lower + limits.upper)
    return np.where((limits.lower < -0.5) & (limits.upper > 0.5), 0.0, centre)


def box(robot):
    """Return the lowest and highest joint positions (n,) that motions keep between [rad]."""
    middle, limits = middle_pose(robot), robot.limits
    low = np.maximum(middle - REACH, limits.lower + _MARGIN)
    high = np.minimum(middle + REACH, limits.upper - _MARGIN)
    return np.minimum(low, middle), np.maximum(high, middle)


def _is_bearable(robot, samples, share=None):
    """Tell whether a share of the drives' torque moves q, v, a samples with the rated load."""
    share = robot.limits.allowed_torque if share is None else share
    load = robot.file.rated_load
    torque = np.array([robot.rigid_torque(*row, load) for row in zip(*samples)])
    return bool(np.all(np.abs(torque) <= share * robot.limits.torque))


def _move(robot, start, goal, speed):
    """Return the quickest bearable quintic from rest to rest, or None where none is."""
    distance, limits = np.abs(goal - start), robot.limits
    duration = max(_SHORTEST_MOVE, np.max(_QUINTIC_SPEED * distance / limits.velocity),
                   np.max(np.sqrt(_QUINTIC_ACCELERATION * distance / limits.acceleration)))
    rest = np.zeros((2, robot.n))
    for _ in range(8):
        move = Trajectory([0.0, duration / speed], [start, goal], rest, rest)
        if _is_bearable(robot, move.sample(np.linspace(0.0, move.end, 15))):
            return move
        duration *= 1.25
    return None


def pick_place(robot, duration, speed, rng):
    """Return random point-to-point moves with dwells between, as a cell has them."""
    low, high = box(robot)
    here = _bearable_pose(robot, low, high, rng)
    parts, end = [hold(here, rng.uniform(*_DWELL))], 0.0
    end = parts[0].end
    while True:
        goal = _bearable_pose(robot, low, high, rng)
        if np.max(np.abs(goal - here)) < min(_LEAST_TRAVEL, 0.3 * np.max(high - low)):
            continue
        move = _move(robot, here, goal, speed)
        if move is None:
            continue
        dwell = rng.uniform(*_DWELL)
        if end + move.duration + dwell >= duration:
            break
        parts += [move, hold(goal, dwell)]
        end += move.duration + dwell
        here = goal
    if duration > end:
        parts.append(hold(here, duration - end))
    return concatenate(parts)


def _bearable_pose(robot, low, high, rng):
    rest = np.zeros((1, robot.n))
    for _ in range(200):
        pose = rng.uniform(low, high)
        if _is_bearable(robot, (pose[None], rest, rest)):
            return pose
    raise ConfigurationError(f'{robot.file.where}: max_torque',
                             'holds the rated load in hardly any pose',
                             robot.file.max_torque.tolist(),
                             'drives that can hold the rated load')


def excite(robot, duration, speed, rng):
    """Return a random multi-sine of all joints that starts and ends at rest."""
    low, high = box(robot)
    middle, limits = 0.5 * (low + high), robot.limits
    knots = max(int(round(duration / _KNOT)), 4)
    time = np.linspace(0.0, duration, knots + 1)
    omega = 2.0 * np.pi * _FREQUENCIES * speed
    weight = rng.uniform(0.2, 1.0, (len(omega), robot.n)) / omega[:, None]
    phase = rng.uniform(0.0, 2.0 * np.pi, weight.shape)
    motion = faded_sines(time, min(_RAMP / speed, 0.4 * duration), omega, weight, phase)
    peaks = [np.max(np.abs(column), axis=0) for column in motion]
    scale = np.min([0.5 * (high - low) / peaks[0], 0.95 * speed * limits.velocity / peaks[1],
                    0.95 * speed ** 2 * limits.acceleration / peaks[2]], axis=0)
    for _ in range(30):
        q, v, a = (scale * column for column in motion)
        if _is_bearable(robot, (middle + q[::5], v[::5], a[::5]), 1.0):
            break
        scale *= 0.9
    return Trajectory(time, middle + q, v, a)


def faded_sines(time, ramp, omega, weight, phase):
    """
    Return q, v, a (N, n) of a sum of sines that fades in and out over `ramp` [s].

    time (N,) [s]; omega (k,) [rad/s]; weight (k, n) [rad], phase (k, n) [rad].
    """
    angle = omega[:, None] * time
    waves = [np.zeros((len(time), weight.shape[1])) for _ in range(3)]
    for k, w in enumerate(omega):
        sine, cosine = np.sin(angle[k][:, None] + phase[k]), np.cos(angle[k][:, None] + phase[k])
        waves[0] += weight[k] * sine
        waves[1] += weight[k] * w * cosine
        waves[2] -= weight[k] * w * w * sine
    e, de, dde = (column[:, None] for column in _window(time, ramp))
    q, v, a = waves
    return e * q, de * q + e * v, dde * q + 2.0 * de * v + e * a


def _window(time, ramp):
    """Return the window and its derivatives (N,): quintic smooth steps at both ends."""
    s = np.clip(np.minimum(time, time[-1] - time) / ramp, 0.0, 1.0)
    side = np.where(time < 0.5 * time[-1], 1.0, -1.0) / ramp
    return (s ** 3 * (10.0 + s * (-15.0 + 6.0 * s)),
            side * 30.0 * s ** 2 * (1.0 - s) ** 2,
            60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / ramp ** 2)


def stand(robot, duration, speed, rng):
    """Return standing still in a random pose."""
    return hold(_bearable_pose(robot, *box(robot), rng), duration)


MOTIONS = {'pick_place': pick_place, 'excite': excite, 'hold': stand}


def named_motion(name, robot, duration, speed=1.0, seed=0):
    """
    Return the Trajectory of a motion of MOTIONS, from time 0 to `duration` [s].

    speed in (0, 1]: share of the quickest. The same seed gives the same motion.
    """
    return MOTIONS[name](robot, float(duration), float(speed), np.random.default_rng([seed, 7]))
