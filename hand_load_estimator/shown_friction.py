"""
Friction as the motion filter shows it: of the motion before the filter, and then filtered.

Torque is compared behind a low-pass (motion.py). What is smooth may be evaluated at the filtered
motion; friction that turns within a reversal may not: a peak that lasts a few hundredths of a
second is spread over the filter's memory, and the filtered velocity is far from the one that it
belongs to. The motion before the filter F(s) = (w / (s + w))^3 is F(s)^-1 = (1 + s / w)^3 of it,
of which q, v, a and jerk give all but the velocity's last term. There friction is evaluated, as
contacts that bend up to what is left of the Stribeck peak (stribeck_curve.py): where the peak
comes back as a joint slows down, they have to bend again. Then it is passed through the filter.
"""

from functools import lru_cache

import numpy as np

from .motion import BANDWIDTH, filter_step
from .presliding import DEAD_BAND, turned
from .stribeck_curve import left

# Steps within a sample: five milliseconds at the motion filter's rate.
STEPS = 4
# Times between samples are rounded to this [s], so that jitter makes no end of filters.
ROUNDED = 1e-4
# Of a Stribeck peak less than this [-] is nothing.
LEAST_LEVEL = 1e-6
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


def unfiltered(q, v, a, jerk=None):
    """Return position [rad] and velocity [rad/s] before the filter, of the filtered motion."""
    j = 0.0 if jerk is None else jerk / BANDWIDTH
    return (q + (3.0 * v + (3.0 * a + j) / BANDWIDTH) / BANDWIDTH,
            v + 3.0 * (a + j) / BANDWIDTH)


class ShownFriction:
    """
    Follow friction of size one for K places: joints, some of them several times.

    travels (K,) [rad] over which it turns, powers (K,) of the way it does (presliding.turned);
    peak: arguments (K,) of stribeck_curve.left behind the warmth, none where it does not fall.
    """

    def __init__(self, joints, travels, powers, *peak):
        self._joints, self._travels = np.asarray(joints, dtype=int), travels
        self._powers, self._peak = powers, peak
        self._anchor = None

    def update(self, q, v, dt, warmth):
        """Return friction (K,) after dt [s]; q, v (n,): unfiltered; warmth (n,) [K]."""
        q, v = q[self._joints], v[self._joints]
        if self._anchor is None:
            self._anchor, self._speed = q, v
            self._friction, self._stages = np.zeros(len(q)), np.zeros((3, len(q)))
        moved = q - self._anchor
        counts = np.abs(moved) > DEAD_BAND
        moved = np.where(counts, moved, 0.0)
        if self._peak:
            speeds = self._speed + _SHARES * (v - self._speed)
            friction = self._bent(moved / STEPS, left(speeds, warmth[self._joints], *self._peak))
        else:
            friction = turned(self._friction, _SHARES * moved, self._travels, self._powers)
        matrix, gains = _filter(round(dt / ROUNDED))
        self._stages = matrix @ self._stages + gains @ np.vstack([self._friction, friction])
        self._anchor = np.where(counts, q, self._anchor)
        self._friction, self._speed = friction[-1], v
        return self._stages[2]

    def _bent(self, moved, levels):
        """Return friction (STEPS, K) of steps of the same way (K,) under levels (STEPS, K)."""
        out, now = np.empty_like(levels), self._friction
        for k, level in enumerate(np.maximum(levels, LEAST_LEVEL)):
            # Springs of one stiffness: half the level is reached in half the way.
            now = level * turned(now / level, moved, level * self._travels, self._powers)
            out[k] = now
        return out


class ShownStream:
    """What ShownFriction gives sample by sample, for all places that are asked for at once."""

    def __init__(self):
        self.restart()

    def restart(self):
        """Forget the path."""
        self._places = {}

    def at(self, q, v, a, dt, warmth, jerk=None):
        """Return shown(joints, travels, powers, *peak) of EffectInput at a motion (n,)."""
        raw, known = (*unfiltered(q, v, a, jerk), dt, warmth), {}

        def shown(*places):
            several = np.broadcast_arrays(*map(np.atleast_1d, places))
            key = tuple(map(bytes, several))
            if key not in known:
                if key not in self._places:
                    self._places[key] = ShownFriction(*several)
                known[key] = self._places[key].update(*raw)[None]
            return known[key] if any(map(np.ndim, places)) else known[key][:, 0]
        return shown


def shown_along(q, v, a, dt, warmth, jerk=None):
    """
    Return shown(joints, travels, powers, *peak) of EffectInput along a motion (N, n).

    dt (N,) [s]; warmth (N, n) [K]; arguments as of ShownFriction for (N, K), or plain numbers for
    (N,).
    """
    raw_q, raw_v = unfiltered(q, v, a, jerk)

    def shown(*places):
        state = ShownFriction(*np.broadcast_arrays(*map(np.atleast_1d, places)))
        found = np.array([state.update(*row) for row in zip(raw_q, raw_v, dt.tolist(), warmth)])
        return found if any(map(np.ndim, places)) else found[:, 0]
    return shown
