"""
Friction as the motion filter shows it: of the motion before the filter, and then filtered.

Torque is compared behind a low-pass (motion.py). What is smooth may be evaluated at the filtered
motion; friction that turns within a reversal may not: a peak that lasts a few hundredths of a
second is spread over the filter's memory, and the filtered velocity is far from the one that it
belongs to. So friction is evaluated along the motion as it was measured (course.py), as contacts
that bend up to what is left of the Stribeck peak (stribeck_curve.py): where the peak comes back
as a joint slows down, they have to bend again. Then it is passed through the filter.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import repeat

import numpy as np

from ..course import SHARES, STEPS, Ways
from ..effects.stribeck_curve import left
from ..motion import BANDWIDTH, filter_step
from .lock_step import lock_step
from .presliding import Turning

# Times between samples are rounded to this [s], so that jitter makes no end of filters.
ROUNDED = 1e-4
# Of a Stribeck peak less than this [-] is nothing.
LEAST_LEVEL = 1e-6
# So many samples are prepared at once: all of a long recording would fill the memory.
ROWS = 512
# Friction is never so far from zero [-].
FAR = 2.0


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


def course_of(motion):
    """
    Return the course of a Motion (N, 2, STEPS, n) or of a MotionSample (2, STEPS, n).

    Where no filter has seen it: that of which the filter would have made it.
    """
    if motion.course is not None:
        return motion.course
    return course_behind(motion.q, motion.v, motion.a, motion.dt)


def course_behind(q, v, a, dt):
    """
    Return the course (..., 2, STEPS, n) of which the filter would have made q, v, a (..., n).

    As far as these tell: F(s)^-1 = (1 + s / w)^3. dt (...) [s]: since the sample before.
    """
    back = np.asarray(dt)[..., None, None] * (1.0 - SHARES)[:, None]
    q, v, a = (part[..., None, :] for part in (q, v, a))
    q, v, a = q - back * (v - 0.5 * back * a), v - back * a, a + np.zeros_like(back)
    return np.stack([q + 3.0 * (v + a / BANDWIDTH) / BANDWIDTH, v + 3.0 * a / BANDWIDTH], axis=-3)


class _Contacts:
    """Friction (K,) of size one that turns over travels (K,) with powers (K,), or below levels."""

    def __init__(self, travels, powers):
        self._travels, self._turning = travels, Turning(powers)
        self.friction = np.zeros(len(travels))

    def ways(self, moved, levels):
        """
        Return what `bend` takes, for any number of samples at once.

        moved (..., STEPS, K) [rad] within each; levels (..., STEPS + 1, K) before, within and
        after, or None for one of one.
        """
        travels = self._travels
        if levels is not None:
            # Half of each step's way at the level before it, half at the one after: of second
            # order in the step. Springs of one stiffness: half the level, half the way.
            levels = np.maximum(np.repeat(levels, 2, axis=-2)[..., 1:-1, :], LEAST_LEVEL)
            moved, travels = 0.5 * np.repeat(moved, 2, axis=-2), levels * travels
        return np.sign(moved), self._turning.bends(np.abs(moved) / travels), levels

    def bend(self, directions, bends, levels):
        """Return friction (STEPS + 1, K) as it was and within a sample, before the filter."""
        out = np.empty((len(bends) + 1, bends.shape[1]))
        out[0] = friction = self.friction
        after, stands = self._turning.after, not directions.all()
        for k, (direction, bend) in enumerate(zip(directions, bends)):
            level = 1.0 if levels is None else levels[k]
            remains = after(np.maximum(1.0 - direction * friction / level, 0.0), bend)
            turned = direction * (level - level * remains)
            friction = np.where(direction != 0.0, turned, friction) if stands else turned
            out[k + 1] = friction
        self.friction = friction
        return out[::len(bends) // STEPS]

    def bend_along(self, directions, bends, levels):
        """Return what `bend` does of N samples (N, ...), one after the other."""
        if self._turning.endless:
            return self._clipped_along(bends, directions * (1.0 if levels is None else levels))
        rows = zip(directions, bends, repeat(None) if levels is None else levels)
        return np.array([self.bend(*row) for row in rows])

    def _clipped_along(self, kept, towards):
        """
        Return bend_along of powers that are infinite, of which `kept` is left of a way to a level.

        Each step then is f -> clip(kept f + (1 - kept) towards), and all of a sample one such.
        """
        gain, shift = np.ones_like(kept[:, 0]), np.zeros_like(kept[:, 0])
        least, most = shift - FAR, shift + FAR
        maps = [(gain, shift, least, most)]
        for keep, level in zip(kept.swapaxes(0, 1), towards.swapaxes(0, 1)):
            moved = (1.0 - keep) * level
            lowest, highest = np.where(level < 0.0, level, -FAR), np.where(level > 0.0, level, FAR)
            gain, shift = keep * gain, keep * shift + moved
            least, most = (np.clip(keep * end + moved, lowest, highest) for end in (least, most))
            maps.append((gain, shift, least, most))
        before, friction = np.empty_like(gain), self.friction
        for row, (scale, add, low, high) in enumerate(zip(*maps[-1])):
            before[row] = friction
            friction = np.minimum(np.maximum(scale * friction + add, low), high)
        self.friction = friction
        return np.stack([np.clip(scale * before + add, low, high) for scale, add, low, high
                         in maps[::len(towards[0]) // STEPS]], axis=1)


class ShownFriction:
    """
    Follow friction of size one for K places: joints, some of them several times.

    travels (K,) [rad] over which it turns, powers (K,) of the way it does (presliding.Turning);
    peak: arguments (K,) of stribeck_curve.left behind the warmth, none where it does not fall.
    """

    def __init__(self, joints, travels, powers, *peak):
        self._joints, self._peak = np.asarray(joints, dtype=int), peak
        self._contacts = _Contacts(travels, powers)
        self._ways, self._stages = None, np.zeros((3, len(self._joints)))

    def update(self, course, dt, warmth):
        """Return friction (K,) after a course (2, STEPS, n) of dt [s]; warmth (n,) [K]."""
        q, v = course[:, :, self._joints]
        if self._ways is None:
            self._ways, self._speed = Ways(q[0]), v[0]
        moved, contacts = self._ways.along(q), self._contacts
        speeds, self._speed = np.vstack([self._speed, v]), v[-1]
        levels = left(speeds, warmth[self._joints], *self._peak) if self._peak else None
        self._stages = _filtered(self._stages, contacts.bend(*contacts.ways(moved, levels)), dt)
        return self._stages[2]


class ShownStream:
    """What ShownFriction gives sample by sample, for all places that are asked for at once."""

    def __init__(self):
        self.restart()

    def restart(self):
        """Forget the path."""
        self._places = {}

    def at(self, *motion):
        """Return shown(joints, travels, powers, *peak) of EffectInput; as of update."""
        known = {}

        def shown(*places):
            several = np.broadcast_arrays(*map(np.atleast_1d, places))
            key = tuple(map(bytes, several))
            if key not in known:
                if key not in self._places:
                    self._places[key] = ShownFriction(*several)
                known[key] = self._places[key].update(*motion)[None]
            return known[key] if any(map(np.ndim, places)) else known[key][:, 0]
        return shown


@dataclass(frozen=True)
class ShownAlong:
    """
    shown(joints, travels, powers, *peak) of EffectInput along recordings, one after the other.

    parts: (course (N, 2, STEPS, n), warmth (N, n) [K], dt (N,) [s]) of each. Arguments of a call
    as of ShownFriction for (N, K), or plain numbers for (N,).
    """

    parts: tuple

    def __call__(self, *places):
        several = np.broadcast_arrays(*map(np.atleast_1d, places))
        found = np.concatenate(lock_step(
            self._prepared, lambda numbers, rows: self._follow(len(numbers), several, rows)))
        return found if any(map(np.ndim, places)) else found[:, 0]

    @cached_property
    def _prepared(self):
        """Ways (N, STEPS, n), speeds (N, STEPS + 1, n), warmth (N, 1, n), dt (N, 1) of each."""
        out = []
        for course, warmth, dt in self.parts:
            q, v = course.swapaxes(0, 1)
            ways = Ways(q[0, 0])
            moved = np.array([ways.along(own) for own in q])
            before = np.concatenate([v[:1, :1], v[:-1, -1:]])
            out.append((moved, np.hstack([before, v]), warmth[:, None], dt[:, None]))
        return out

    @staticmethod
    def _follow(count, places, rows):
        """Return friction (L, K of all) of `count` parts; places: (joints, figures) of each."""
        *motion, dt = rows
        n, (joints, *figures) = motion[0].shape[2] // count, places
        travels, powers, *peak = (np.tile(figure, count) for figure in figures)
        joints = np.concatenate([joints + k * n for k in range(count)])
        contacts, stages = _Contacts(travels, powers), np.zeros((count, 3, len(joints) // count))
        out = []
        for first in range(0, len(dt), ROWS):
            some = slice(first, first + ROWS)
            moved, v, warmth = (values[some, :, joints] for values in motion)
            levels = left(v, warmth, *peak) if peak else None
            bent = contacts.bend_along(*contacts.ways(moved, levels))
            shown = _filtered_along(stages, bent.reshape(len(bent), STEPS + 1, count, -1)
                                    .swapaxes(1, 2), dt[some])
            stages = shown[-1]
            out.append(shown[:, :, 2].reshape(len(bent), -1))
        return np.concatenate(out)


def shown_along(course, dt, warmth):
    """Return ShownAlong one course (N, 2, STEPS, n); dt (N,) [s]; warmth (N, n) [K]."""
    return ShownAlong(((course, warmth, dt),))
