"""
Friction as the motion filter shows it: of the motion before the filter, and then filtered.

Torque is compared behind a low-pass (motion.py). What is smooth may be evaluated at the filtered
motion; friction that turns within a reversal may not: a peak that lasts a few hundredths of a
second is spread over the filter's memory, and the filtered velocity is far from the one that it
belongs to. The motion before the filter F(s) = (w / (s + w))^3 is F(s)^-1 = (1 + s / w)^3 of it,
of which q, v and a give all but the last term. There friction is evaluated, as the presliding
state times what is left of the Stribeck peak at that speed, and passed through the same filter.
"""

from functools import lru_cache

import numpy as np

from .motion import BANDWIDTH, filter_step
from .presliding import DEAD_BAND, turned

# Steps within a sample: five milliseconds at the motion filter's rate.
STEPS = 4
# Times between samples are rounded to this [s], so that jitter makes no end of filters.
ROUNDED = 1e-4
_SHARES = np.arange(1, STEPS + 1)[:, None] / STEPS


@lru_cache(maxsize=4096)
def _filter(count):
    """Return the filter over `count` ROUNDED: (3, 3), and (3, STEPS + 1) of inputs in between."""
    matrix, before, now = filter_step(max(count, 1) * ROUNDED / STEPS)
    gains, whole = np.zeros((3, STEPS + 1)), np.eye(3)
    for k in range(STEPS, 0, -1):
        gains[:, k - 1] += whole @ before
        gains[:, k] += whole @ now
        whole = whole @ matrix
    return whole, gains


def unfiltered(q, v, a):
    """Return position [rad] and velocity [rad/s] before the filter, of filtered q, v, a."""
    return q + (3.0 * v + 3.0 * a / BANDWIDTH) / BANDWIDTH, v + 3.0 * a / BANDWIDTH


class ShownFriction:
    """
    Follow friction of size one for K places: joints, some of them several times.

    travels (K,) [rad] over which it turns, powers (K,) of the way it does (presliding.turned);
    velocities (K,) [rad/s] at which 1 / e of it is left, infinite where it does not fall.
    """

    def __init__(self, joints, travels, powers, velocities):
        self._joints, self._travels = np.asarray(joints, dtype=int), travels
        self._powers, self._velocities = powers, velocities
        self._anchor = None

    def update(self, q, v, dt):
        """Return friction (K,) after dt [s]; q, v (n,): unfiltered."""
        q, v = q[self._joints], v[self._joints]
        if self._anchor is None:
            self._anchor, self._speed = q, v
            self._z, self._friction = np.zeros((2, len(q)))
            self._stages = np.zeros((3, len(q)))
        moved = q - self._anchor
        counts = np.abs(moved) > DEAD_BAND
        moved = np.where(counts, moved, 0.0)
        z = turned(self._z, _SHARES * moved, self._travels, self._powers)
        speeds = self._speed + _SHARES * (v - self._speed)
        friction = z * np.exp(-np.abs(speeds) / self._velocities)
        matrix, gains = _filter(round(dt / ROUNDED))
        self._stages = matrix @ self._stages + gains @ np.vstack([self._friction, friction])
        self._anchor = np.where(counts, q, self._anchor)
        self._z, self._friction, self._speed = z[-1], friction[-1], v
        return self._stages[2]


class ShownStream:
    """What ShownFriction gives sample by sample, for every place that is asked for."""

    def __init__(self):
        self.restart()

    def restart(self):
        """Forget the path."""
        self._places = {}

    def at(self, q, v, a, dt):
        """Return shown(joints, travels, powers, velocities) of EffectInput at q, v, a (n,)."""
        raw, known = (*unfiltered(q, v, a), dt), {}

        def one(*place):
            if place not in known:
                state = self._places.setdefault(place, ShownFriction(*np.array([place]).T))
                known[place] = state.update(*raw)[0]
            return known[place]

        def shown(*places):
            several = np.broadcast_arrays(*map(np.atleast_1d, places))
            found = np.array([[one(*place) for place in zip(*several)]])
            return found if any(map(np.ndim, places)) else found[:, 0]
        return shown


def shown_along(q, v, a, dt):
    """
    Return shown(joints, travels, powers, velocities) of EffectInput along a motion (N, n).

    dt (N,) [s]; arguments as of ShownFriction for (N, K), or plain numbers for (N,).
    """
    raw_q, raw_v = unfiltered(q, v, a)

    def shown(*places):
        state = ShownFriction(*np.broadcast_arrays(*map(np.atleast_1d, places)))
        found = np.array([state.update(*row) for row in zip(raw_q, raw_v, dt.tolist())])
        return found if any(map(np.ndim, places)) else found[:, 0]
    return shown
