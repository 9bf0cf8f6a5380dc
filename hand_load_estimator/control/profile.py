"""Speed profile along a path: accelerate, cruise, decelerate, with linear acceleration ramps."""

from dataclasses import dataclass

import numpy as np

_TOO_SHORT = 1e-9  # [s] pieces shorter than this are left out


@dataclass(frozen=True)
class PathLimits:
    """
    Limits along a path of length 1.

    speed [1/s]; acceleration, deceleration [1/s^2] (positive magnitudes); jerk [1/s^3]: how
    fast they build up, so that the drives see no torque step.
    """

    speed: float
    acceleration: float
    deceleration: float
    jerk: float


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


def _speed_change(v, a, target, limit, jerk):
    """
    Return pieces [(duration, acceleration at its end)] from (v, a) to (target, 0).

    The acceleration goes to at most +-limit, stays, and goes to zero. `a` is not negative, and
    zero where the speed falls; target is at least what fading `a` out leads to.
    """
    gap = abs(target - v)
    peak = min(limit, np.sqrt(jerk * gap + 0.5 * a * a))
    if peak == 0.0:
        return []
    ramps = (abs(peak * peak - a * a) + peak * peak) / (2.0 * jerk)
    held = max(0.0, gap - ramps) / peak
    peak_signed = peak if target > v else -peak
    return [(abs(peak - a) / jerk, peak_signed), (held, peak_signed), (peak / jerk, 0.0)]


def _distance(v, a, pieces):
    s = 0.0
    for duration, end in pieces:
        if duration > _TOO_SHORT:
            s, v, a = _advance(s, v, a, duration, (end - a) / duration)
    return s


def _used_distance(state, peak, limits):
    """Return the path used by reaching the speed `peak` and stopping from it at once."""
    _, v, a = state
    return _distance(v, a, _speed_change(v, a, peak, limits.acceleration, limits.jerk)) \
        + _distance(peak, 0.0, _speed_change(peak, 0.0, 0.0, limits.deceleration, limits.jerk))


def _peak_speed(state, limits):
    """Return the highest speed that still lets the path end at rest; None when none does."""
    s, v, a = state
    coasting = v + a * a / (2.0 * limits.jerk)
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
    # A cruising state carries rounding in its acceleration.
    state = (state[0], state[1], max(state[2], 0.0))
    peak = _peak_speed(state, limits)
    if peak is None or peak <= 0.0:
        return None
    up = _speed_change(state[1], state[2], peak, limits.acceleration, limits.jerk)
    down = _speed_change(peak, 0.0, 0.0, limits.deceleration, limits.jerk)
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
