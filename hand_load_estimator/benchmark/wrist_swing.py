"""The motion of the inertia suite: wrists swing fast enough for a load's inertia to be felt."""

import numpy as np

from ..errors import ConfigurationError
from ..motions.trajectory import Trajectory
from ..simulation.simulate_motions import box, faded_sines

WRIST_SWING = 'wrist_swing'
# [Hz] of the last three joints, and of those before them.
_WRIST = np.array([0.55, 0.8, 1.1])
_ARM = np.array([0.07, 0.13, 0.19])
_WRISTS = 3
LEAST_ACCELERATION = 10.0   # [rad/s^2] that each wrist joint reaches
_RAMP, _KNOT = 1.0, 0.01    # [s]
_TRIES = 100


def wrist_swing(robot, duration, rng):
    """
    Return a Trajectory of `duration` [s] from rest to rest around a pose that rng draws.

    Inside the limits of position, speed, acceleration and, with the rated load, torque; each
    wrist joint reaches LEAST_ACCELERATION. Raises ConfigurationError for an arm that cannot.
    """
    time = np.linspace(0.0, duration, max(int(round(duration / _KNOT)), 4) + 1)
    wrist = np.arange(robot.n) >= robot.n - _WRISTS
    parts = [faded_sines(time, _RAMP, 2.0 * np.pi * f,
                         rng.uniform(0.2, 1.0, (len(f), robot.n)) * joints,
                         rng.uniform(0.0, 2.0 * np.pi, (len(f), robot.n)))
             for f, joints in ((_WRIST, wrist), (_ARM, ~wrist))]
    q, v, a = (first + second for first, second in zip(*parts))
    for k in range(_TRIES):
        middle = rng.uniform(*box(robot))
        # The arm's sweep costs torque and tells no inertia: it gives way, the wrists do not.
        scale = _scale(robot, middle, q, v, a) * np.where(wrist, 1.0, 0.95 ** k)
        motion = Trajectory(time, middle + scale * q, scale * v, scale * a)
        fast = np.max(np.abs(motion.acceleration[:, wrist]), axis=0) >= LEAST_ACCELERATION
        if fast.all() and _bearable(robot, motion):
            return motion
    raise ConfigurationError(f'{robot.file.where}: max_torque',
                             f'swings the rated load with {LEAST_ACCELERATION:g} rad/s^2 in '
                             'hardly any pose', robot.limits.torque.tolist(),
                             'a robot with stronger or faster wrists')


def _scale(robot, middle, q, v, a):
    """Return the largest factor (n,) that keeps each joint inside its own limits."""
    limits = robot.limits
    room = np.minimum(np.minimum(middle - limits.lower, limits.upper - middle) - 0.02, 1.0)
    peaks = [np.max(np.abs(column), axis=0) for column in (q, v, a)]
    return np.min([room / peaks[0], 0.95 * limits.velocity / peaks[1],
                   0.95 * limits.acceleration / peaks[2]], axis=0)


def _bearable(robot, motion):
    rows = zip(motion.position[::5], motion.velocity[::5], motion.acceleration[::5])
    torque = np.array([robot.rigid_torque(q, v, a, robot.rated_load) for q, v, a in rows])
    return bool(np.all(np.abs(torque) <= robot.limits.allowed_torque * robot.limits.torque))
