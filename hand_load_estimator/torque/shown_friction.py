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
from functools import cached_property, lru_cache
from itertools import repeat

import numpy as np

from ..effects.stribeck_curve import left
from ..motion import BANDWIDTH, filter_step
from .lock_step import lock_step
from .presliding import beyond_noise, Turning, ways_along

# Steps within a sample: five milliseconds at the motion filter's rate.
STEPS = 4
# Times between samples are rounded to this [s], so that jitter makes no end of filters.
ROUNDED = 1e-4
# Of a Stribeck peak less than this [-] is nothing.
LEAST_LEVEL = 1e-6
# So many samples are prepared at once: all of a long recording would fill the memory.
ROWS = 512
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


def _filtered_along(stages, friction, dt):
    """
    Return the filter's stages (L, parts, 3, k) after each of L samples of parts side by side.

    stages (parts, 3, k) before them; friction (L, parts, STEPS + 1, k); dt (L, parts) [s].
    """
    counts, which = np.unique(np.round(dt / ROUNDED).astype(int), return_inverse=True)
    matrices, gains = (np.stack(those)[which.reshape(dt.shape)]
                       for those in zip(*map(_filter, counts.tolist())))
    out = gains @ friction
    for matrix, row in zip(matrices, out):
        row += matrix @ stages
        stages = row
    return out


def unfiltered(q, v, a, jerk=None):
    """Return position [rad] and velocity [rad/s] before the filter, of the filtered motion."""
    j = 0.0 if jerk is None else jerk / BANDWIDTH
    return (q + (3.0 * v + (3.0 * a + j) / BANDWIDTH) / BANDWIDTH,
            v + 3.0 * (a + j) / BANDWIDTH)


class _Contacts:
    """Friction (K,) of size one that turns over travels (K,) with powers (K,), or below levels."""

    def __init__(self, travels, powers):
        self._travels, self._turning = travels, Turning(powers)
        self.friction = np.zeros(len(travels))

    def ways(self, moved, levels):
        """
        Return what `bend` takes, for any number of samples at once.

        moved (..., K) [rad] within each; levels (..., STEPS, K), or None for a level of one.
        """
        way = np.abs(moved)[..., None, :]
        if levels is None:
            return np.sign(moved), self._turning.bends(_SHARES * way / self._travels), None
        levels = np.maximum(levels, LEAST_LEVEL)
        # Springs of one stiffness: half the level is reached in half the way.
        return (np.sign(moved), self._turning.bends(way / STEPS / (levels * self._travels)),
                levels)

    def bend(self, direction, bends, levels):
        """Return friction (STEPS + 1, K) as it was and within a sample, before the filter."""
        out = np.empty((STEPS + 1, len(direction)))
        out[0] = self.friction
        along, after = direction * self.friction, self._turning.after
        if levels is None:
            out[1:] = direction * (1.0 - after(np.maximum(1.0 - along, 0.0), bends))
        else:
            for k, level in enumerate(levels):
                along = level - level * after(np.maximum(1.0 - along / level, 0.0), bends[k])
                out[k + 1] = along
            out[1:] *= direction
        if not direction.all():
            out[1:] = np.where(direction != 0.0, out[1:], self.friction)
        self.friction = out[STEPS]
        return out


class ShownFriction:
    """
    Follow friction of size one for K places: joints, some of them several times.

    travels (K,) [rad] over which it turns, powers (K,) of the way it does (presliding.Turning);
    peak: arguments (K,) of stribeck_curve.left behind the warmth, none where it does not fall.
    """

    def __init__(self, joints, travels, powers, *peak):
        self._joints, self._peak = np.asarray(joints, dtype=int), peak
        self._contacts = _Contacts(travels, powers)
        self._anchor, self._stages = None, np.zeros((3, len(self._joints)))

    def update(self, q, v, dt, warmth):
        """Return friction (K,) after dt [s]; q, v (n,): unfiltered; warmth (n,) [K]."""
        q, v = q[self._joints], v[self._joints]
        if self._anchor is None:
            self._anchor, self._speed = q, v
        moved, self._anchor = beyond_noise(q, self._anchor)
        levels = left(_speeds(self._speed, v), warmth[self._joints], *self._peak) \
            if self._peak else None
        self._speed, contacts = v, self._contacts
        self._stages = _filtered(self._stages, contacts.bend(*contacts.ways(moved, levels)), dt)
        return self._stages[2]


def _speeds(before, now):
    """Return the speeds (..., STEPS, K) within samples between speeds (..., K)."""
    before, now = before[..., None, :], now[..., None, :]
    return before + _SHARES * (now - before)


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
        found = np.concatenate(lock_step(
            self._prepared, lambda numbers, rows: self._follow(len(numbers), several, rows)))
        return found if any(map(np.ndim, places)) else found[:, 0]

    @cached_property
    def _prepared(self):
        """Way, speeds before and after, warmth (N, n) and dt (N, 1) of each part."""
        out = []
        for q, v, warmth, dt in self.parts:
            out.append((ways_along(q), np.concatenate([v[:1], v[:-1]]), v, warmth, dt[:, None]))
        return out

    @staticmethod
    def _follow(count, places, rows):
        """Return friction (L, K of all) of `count` parts; places: (joints, figures) of each."""
        *motion, dt = rows
        n, (joints, *figures) = motion[0].shape[1] // count, places
        travels, powers, *peak = (np.tile(figure, count) for figure in figures)
        joints = np.concatenate([joints + k * n for k in range(count)])
        contacts, stages = _Contacts(travels, powers), np.zeros((count, 3, len(joints) // count))
        out = []
        for first in range(0, len(dt), ROWS):
            some = slice(first, first + ROWS)
            moved, before, now, warmth = (values[some, joints] for values in motion)
            levels = left(_speeds(before, now), warmth[:, None], *peak) if peak else None
            bent = np.array([contacts.bend(*row) for row in _rows(contacts.ways(moved, levels))])
            shown = _filtered_along(stages, bent.reshape(len(bent), STEPS + 1, count, -1)
                                    .swapaxes(1, 2), dt[some])
            stages = shown[-1]
            out.append(shown[:, :, 2].reshape(len(bent), -1))
        return np.concatenate(out)


def _rows(arrays):
    """Yield the rows of arrays, None for what is none."""
    return zip(*(repeat(None) if values is None else values for values in arrays))


def shown_along(q, v, a, dt, warmth, jerk=None):
    """Return ShownAlong one motion (N, n) behind the filter; dt (N,) [s]; warmth (N, n) [K]."""
    return ShownAlong(((*unfiltered(q, v, a, jerk), warmth, dt),))
