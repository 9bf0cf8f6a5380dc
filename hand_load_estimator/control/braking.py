"""Stop from any state of motion: every joint to rest at the same time, within its torque."""

import numpy as np

from ..motions.trajectory import Trajectory

_RAMP = 0.05           # [s] rise and fall of the deceleration, so that the drives see no step
_STOP_TIMES = np.geomspace(0.12, 2.0, 18)
_SAMPLES = 9
_WORTH = 1.1           # times the least torque: a stop that uses no more is as good


def braking_trajectory(q, v, use, max_acceleration):
    """
    Return the shortest Trajectory to rest that keeps the torques, from time 0 on.

    q, v (n,): state now [rad], [rad/s]; use: TorqueUse; max_acceleration (n,) [rad/s^2]. When no
    stop keeps the torques, the shortest that uses hardly more than the one that uses least. The
    last knot has zero velocity.
    """
    q, v = np.asarray(q, dtype=float), np.asarray(v, dtype=float)
    tried = []
    for duration in _STOP_TIMES:
        trajectory = _stop(q, v, duration)
        times = np.linspace(0.0, duration, _SAMPLES)
        positions, velocities, accelerations = trajectory.sample(times)
        share = use.worst(positions, velocities, accelerations)
        share = max(share, float(np.max(np.abs(accelerations) / max_acceleration)))
        if share <= 1.0:
            return trajectory
        tried.append((share, trajectory))
    least = min(share for share, _ in tried)
    # What holding the arm takes, all stops need: a little less of it is not worth travelling on.
    return next(trajectory for share, trajectory in tried if share <= _WORTH * least)


def _stop(q, v, duration):
    """Return the stop whose deceleration rises, stays and falls: its knots and its ends."""
    peak = v / (duration - _RAMP)
    held = duration - 2.0 * _RAMP
    v1 = v - 0.5 * peak * _RAMP
    v2 = v1 - peak * held
    q1 = q + v * _RAMP - peak * _RAMP ** 2 / 6.0
    q2 = q1 + v1 * held - 0.5 * peak * held ** 2
    q3 = q2 + v2 * _RAMP - peak * _RAMP ** 2 / 3.0
    zero = np.zeros_like(q)
    return Trajectory([0.0, _RAMP, _RAMP + held, duration], [q, q1, q2, q3], [v, v1, v2, zero],
                      [zero, -peak, -peak, zero])
