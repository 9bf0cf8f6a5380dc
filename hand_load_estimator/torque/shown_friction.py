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

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..effects.stribeck_curve import left
from ..motion import BANDWIDTH, filter_step
from .lock_step import lock_step
from .presliding import DEAD_BAND, turned

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


def _filtered(stages, friction, dt):
    """Return the filter's stages (3, K) dt [s] on, under friction (STEPS + 1, K)."""
    matrix, gains = _filter(round(dt / ROUNDED))
    return matrix @ stages + gains @ friction


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
        self._anchor, self._stages = None, np.zeros((3, len(self._joints)))

    def update(self, q, v, dt, warmth):
        """Return friction (K,) after dt [s]; q, v (n,): unfiltered; warmth (n,) [K]."""
        self._stages = _filtered(self._stages, self.bend(q, v, warmth), dt)
        return self._stages[2]

    def bend(self, q, v, warmth):
        """Return friction (STEPS + 1, K) as it was and within the sample, before the filter."""
        q, v = q[self._joints], v[self._joints]
        if self._anchor is None:
            self._anchor, self._speed, self._friction = q, v, np.zeros(len(q))
        moved = q - self._anchor
        counts = np.abs(moved) > DEAD_BAND
        moved = np.where(counts, moved, 0.0)
        if self._peak:
            speeds = self._speed + _SHARES * (v - self._speed)
            friction = self._bent(moved / STEPS, left(speeds, warmth[self._joints], *self._peak))
        else:
            friction = turned(self._friction, _SHARES * moved, self._travels, self._powers)
        before, self._friction = self._friction, friction[-1]
        self._anchor, self._speed = np.where(counts, q, self._anchor), v
        return np.concatenate([before[None], friction])

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


@dataclass(frozen=True)
class ShownAlong:
    """
    shown(joints, travels, powers, *peak) of EffectInput along recordings, one after the other.

    parts: (q, v (N, n) unfiltered, warmth (N, n) [K], dt (N,) [s]) of each. Arguments of a call as
    of ShownFriction for (N, K), or plain numbers for (N,).
    """

    parts: tuple

    def __call__(self, *places):
        several = np.broadcast_arrays(*map(np.atleast_1d, places))
        parts = [(q, v, warmth, dt[:, None]) for q, v, warmth, dt in self.parts]
        found = np.concatenate(lock_step(
            parts, lambda numbers, rows: self._follow(len(numbers), *several, rows)))
        return found if any(map(np.ndim, places)) else found[:, 0]

    def _follow(self, count, joints, *others):
        """Return friction (L, K of all) of `count` parts."""
        *others, rows = others
        n = rows[0].shape[1] // count
        state = ShownFriction(np.concatenate([joints + k * n for k in range(count)]),
                              *(np.tile(other, count) for other in others))
        stages, out = np.zeros((count, 3, len(joints))), []
        for *motion, dt in zip(*rows):
            friction = state.bend(*motion).reshape(STEPS + 1, count, len(joints))
            stages = np.stack([_filtered(stages[k], friction[:, k], dt[k])
                               for k in range(count)])
            out.append(stages[:, 2].ravel())
        return np.array(out)


def shown_along(q, v, a, dt, warmth, jerk=None):
    """Return ShownAlong one motion (N, n) behind the filter; dt (N,) [s]; warmth (N, n) [K]."""
    return ShownAlong(((*unfiltered(q, v, a, jerk), warmth, dt),))
