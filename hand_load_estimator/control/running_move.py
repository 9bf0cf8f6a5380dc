"""A move under way: where it should be now, and a better rest of it when the load is known."""

import numpy as np

from ..motions.trajectory import Trajectory

LEAD = 0.05            # [s] from computing a new rest to its beginning: message and first cycle
_WORTH = 0.03          # [s] a rest that is not faster by this much is not sent


class RunningMove:
    """
    A PlannedMove that began at `begin` [s].

    `trajectory` is what was sent, in absolute time; state(now) its position, velocity and
    acceleration.
    """

    def __init__(self, move, begin):
        self.move, self.goal = move, move.goal
        self.trajectory = move.trajectory().shifted(begin)
        self._origin = begin

    @property
    def end(self):
        """Time of arrival [s]."""
        return self.trajectory.end

    def state(self, now):
        """Return position, velocity, acceleration (n,) at `now` [s]."""
        return self.trajectory.sample(now)

    def shift(self, step):
        """Count everything from a clock that went by step [s]."""
        self.trajectory, self._origin = self.trajectory.shifted(step), self._origin + step

    def replan(self, now, planner, belief, temperature, caution):
        """
        Plan the rest for what is known of the load now (E8.2); return whether it has changed.

        Faster where the load allows it, slower where it demands it. Once the move decelerates
        it is left alone.
        """
        elapsed = now + LEAD - self._origin
        if elapsed <= 0.0 or elapsed >= self.move.profile.time[self.move.profile.first_brake]:
            return False
        safe = planner.use(self.move, belief, temperature, elapsed) <= 1.0
        if safe and self.move.limits == self.move.top:
            return False
        rest = planner.rest(self.move, elapsed, belief, temperature, caution)
        if rest is None:
            return False
        faster = rest.duration < self.move.duration - elapsed - _WORTH
        if safe and not faster:
            return False
        self._join(now, rest)
        return True

    def _join(self, now, rest):
        """Follow `rest` after LEAD, joined to where the motion is now."""
        state, knots = self.state(now), rest.trajectory()
        self.trajectory = Trajectory(
            np.concatenate([[now], now + LEAD + knots.time]),
            *(np.vstack([first, column]) for first, column in zip(
                state, (knots.position, knots.velocity, knots.acceleration))))
        self.move, self._origin = rest, now + LEAD
