"""A point-to-point move as planned: a straight line in joint space with a speed profile."""

from dataclasses import dataclass

import numpy as np

from ..motions.trajectory import Trajectory
from .profile import PathLimits, Profile


@dataclass(frozen=True, eq=False)
class MotionLimits:
    """Limits per joint, (n,) positive magnitudes: [rad/s], [rad/s^2], [rad/s^2]."""

    velocity: np.ndarray
    acceleration: np.ndarray
    deceleration: np.ndarray


@dataclass(frozen=True, eq=False)
class PlannedMove:
    """
    A move from start (n,) to goal (n,) [rad].

    profile runs over the path coordinate of that line, perhaps from its middle on (a re-planned
    rest); limits: what the torques allow along it; top: what the robot file allows; basis: the
    load it was computed for, `estimate` or `rated`; feasible False: no acceleration keeps the
    torques, the move is slow and `reason` says why.
    """

    start: np.ndarray
    goal: np.ndarray
    profile: Profile
    limits: PathLimits
    top: PathLimits
    basis: str
    feasible: bool = True
    reason: str = ''

    @property
    def duration(self):
        """Time from the profile's beginning to rest at the goal [s]."""
        return self.profile.duration

    def points(self, times):
        """Return position, velocity, acceleration (m, n) at times (m,) [s]."""
        return self._on_line(*self.profile.sample(np.asarray(times)))

    def trajectory(self):
        """Return the Trajectory through the profile's knots: its quintics are this move."""
        # The knots themselves: a sample at the last one would carry rounding instead of rest.
        profile = self.profile
        return Trajectory(profile.time, *self._on_line(profile.s, profile.v, profile.a))

    def _on_line(self, *profile):
        s, v, a = (np.asarray(x)[:, None] for x in profile)
        line = self.goal - self.start
        return self.start + s * line, v * line, a * line

    def motion_limits(self, joint_limits, speed_scale):
        """
        Return the MotionLimits of all joints during this move.

        One fraction of the robot file's limits for all joints, as planners scale them: the
        fraction this move's torques leave.
        """
        return MotionLimits(
            joint_limits.velocity * speed_scale * self.limits.speed / self.top.speed,
            joint_limits.acceleration * self.limits.acceleration / self.top.acceleration,
            joint_limits.acceleration * self.limits.deceleration / self.top.deceleration)
