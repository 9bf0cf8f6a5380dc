"""Speed profile along a path: accelerate, cruise, decelerate, with linear acceleration ramps."""

from dataclasses import dataclass

import numpy as np

_TOO_SHORT = 1e-9  # [s] pieces shorter than this are left out


@dataclass(frozen=True)
class PathLimits:
    """
    Limits along a path of length 1.

    speed [1/s]; acceleration, deceleration [1/s^2] (positive magnitudes); ramp [s]: time in
    which the acceleration goes from none to all, so that the drives see no torque step.
    """

    speed: float
    acceleration: float
    deceleration: float
    ramp: float


@dataclass(frozen=True)
class Profile:
    """
    Knots (k,) of the path coordinate; between them the acceleration is linear in time.

    time [s] from 0; s in [0, 1]; v [1/s]; a [1/s^2]; first_cruise, first_brake: indices of the
    knots at which accelerating has ended and decelerating begins.
    """

    time: np.ndarray
    s: np.ndarray
    v: np.ndarray
    a: np.ndarray
    first_cruise: int
    first_brake: int

    @property
    def duration(self):
        """Time of the whole profile [s]."""
        return float(self.time[-1])

    @property
    def acceleration_time(self):
        """Time spent accelerating [s]."""
        return float(self.time[self.first_cruise])

    @property
    def deceleration_time(self):
        """Time spent decelerating [s]."""
        return float(self.time[-1] - self.time[self.first_brake])

    def sample(self, t):
        """Return s, v, a at times t (m,) [s], held at the ends."""
        t = np.clip(t, 0.0, self.time[-1])
        i = np.clip(np.searchsorted(self.time, t, side='right') - 1, 0, len(self.time) - 2)
        h = t - self.time[i]
        jerk = (self.a[i + 1] - self.a[i]) / (self.time[i + 1] - self.time[i])
        return _advance(self.s[i], self.v[i], self.a[i], h, jerk)


def _advance(s, v, a, h, jerk):
    return (s + h * (v + h * (a / 2.0 + h * jerk / 6.0)), v + h * (a + h * jerk / 2.0),
            a + h * jerk)


def _speed_change(v, a, target, limit, ramp):
    """
    Return pieces [(duration, acceleration at its end)] from (v, a) to (target, 0).

    The acceleration goes to at most +-limit in one ramp, stays, and goes to zero in one ramp.
    """
    gap = target - v - a * ramp / 2.0
    peak = np.clip(gap / ramp, -limit, limit)
    if abs(peak) <= 1e-9 * limit:
        return [(ramp, 0.0)] if a else []
    held = (gap - peak * ramp) / peak if abs(peak) == limit else 0.0
    return [(ramp, peak), (held, peak), (ramp, 0.0)]


def _distance(v, a, pieces):
    s = 0.0
    for duration, end in pieces:
        if duration > _TOO_SHORT:
            s, v, a = _advance(s, v, a, duration, (end - a) / duration)
    return s


def _used_distance(state, peak, limits):
    """Return the path used by reaching the speed `peak` and stopping from it at once."""
    _, v, a = state
    return _distance(v, a, _speed_change(v, a, peak, limits.acceleration, limits.ramp)) \
        + _distance(peak, 0.0, _speed_change(peak, 0.0, 0.0, limits.deceleration, limits.ramp))


def _peak_speed(state, limits):
    """Return the highest speed that still lets the path end at rest; None when none does."""
    s, v, a = state
    coasting = v + a * limits.ramp / 2.0
    room = 1.0 - s
    if _used_distance(state, coasting, limits) > room + 1e-12:
        return None
    low, high = coasting, max(limits.speed, coasting)
    if _used_distance(state, high, limits) <= room:
        return high
    for _ in range(40):
        middle = 0.5 * (low + high)
        if _used_distance(state, middle, limits) <= room:
            low = middle
        else:
            high = middle
    return low


def make_profile(limits, state=(0.0, 0.0, 0.0)):
    """
    Return the fastest Profile from state (s, v, a) to rest at s = 1; None when it does not fit.

    It does not fit when the path is too short to stop from the state's speed at the given
    deceleration.
    """
    peak = _peak_speed(state, limits)
    if peak is None or peak <= 0.0:
        return None
    up = _speed_change(state[1], state[2], peak, limits.acceleration, limits.ramp)
    down = _speed_change(peak, 0.0, 0.0, limits.deceleration, limits.ramp)
    cruise = max(0.0, 1.0 - state[0] - _used_distance(state, peak, limits)) / peak
    return _integrate(state, (up, [(cruise, 0.0)], down))


def _integrate(state, phases):
    knots, firsts = [(0.0, *state)], []
    for pieces in phases:
        for duration, end in pieces:
            if duration > _TOO_SHORT:
                t, s, v, a = knots[-1]
                knots.append((t + duration,
                              *_advance(s, v, a, duration, (end - a) / duration)))
        firsts.append(len(knots) - 1)
    time, s, v, a = np.array(knots).T
    # Rounding must not leave a crawl behind the goal.
    s[-1], v[-1], a[-1] = 1.0, 0.0, 0.0
    return Profile(time, s, v, a, firsts[0], firsts[1])
