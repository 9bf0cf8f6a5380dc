"""Friction as the motion filter shows it (shown_friction.py), along recordings."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..course import Ways
from ..effects.stribeck_curve import left
from .contact_level import ContactLevel
from .contacts import Contacts
from .lock_step import lock_step
from .shown_filter import filtered_along
from .shown_friction import Apart, begun, directions

# So many samples are prepared at once: all of a long recording would fill the memory.
ROWS = 512
# So many ways of turning are followed side by side: more would fill the memory.
WAYS = 12


@dataclass(frozen=True, eq=False)
class SeenCourse:
    """A recording: course (N, 2, STEPS, n), dt [s] and messages (N,)."""

    course: np.ndarray
    dt: np.ndarray
    messages: np.ndarray

    @cached_property
    def ways(self):
        """Ways (N, STEPS, n) [rad]."""
        ways = Ways(self.course[0, 0, 0])
        return np.array([ways.along(q, *row) for q, *row in zip(
            self.course[:, 0], self.dt, self.messages)])

    @cached_property
    def speeds(self):
        """Speeds (N, STEPS + 1, n) [rad/s] before and within each sample."""
        v = self.course[:, 1]
        return np.hstack([np.concatenate([v[:1, :1], v[:-1, -1:]]), v])

    @cached_property
    def at_once(self):
        """What friction of size one (N, n) would be of contacts that turn at once."""
        first, out = begun(self.speeds[0, 1:]), []
        for way in self.ways:
            out.append(directions(first, way))
            first = out[-1][-1]
        return self.filtered(np.array(out))

    def filtered(self, friction):
        """Return what the filter makes of friction (N, STEPS + 1, K), (N, K)."""
        stages = np.repeat(friction[:1, :1], 3, axis=1)
        return np.concatenate(list(self._stages(stages, friction)))

    def _stages(self, stages, friction):
        for start in range(0, len(friction), ROWS):
            some = slice(start, start + ROWS)
            found = filtered_along(stages, friction[some, None], self.dt[some, None])
            stages = found[-1]
            yield found[:, 0, 2]


@dataclass(frozen=True, eq=False)
class ShownPart:
    """A SeenCourse, its warmth (N, n) [K], and the ContactLevel of its joints, None for none."""

    seen: SeenCourse
    warmth: np.ndarray
    level: ContactLevel | None = None

    @cached_property
    def levels(self):
        """Return what speeds leave of the joints' levels (N, STEPS + 1, n), None for all."""
        if self.level is None:
            return None
        return self.level.fallen(self.seen.speeds, self.warmth[:, None])

    @cached_property
    def moved(self):
        """Ways (N, STEPS, n) [rad], as short as they would be at the reference temperature."""
        ways = self.seen.ways
        return ways if self.level is None else ways / self.level.warmed(self.warmth)[:, None]


@dataclass(frozen=True, eq=False)
class ShownAlong:
    """
    shown(joints, travels, plastic, *peak) of EffectInput along ShownParts, one after the other.

    own: travels [rad] and plastic [-] (n,) over which each joint's friction turns; an infinite
    travel is that one. paths: the joints' friction of size one before the filter,
    (N, STEPS + 1, n) of each part. Arguments of a call as of Apart for (N, K), or plain numbers
    for (N,).
    """

    parts: tuple
    own: tuple
    paths: tuple

    def __call__(self, *places):
        joints, travels, plastic, *peak = np.broadcast_arrays(*map(np.atleast_1d, places))
        apart = np.isfinite(travels)
        found = np.empty((sum(len(part.warmth) for part in self.parts), len(joints)))
        if apart.any():
            found[:, apart] = self._follow(Apart(
                joints[apart], travels[apart], plastic[apart],
                tuple(figure[apart] for figure in peak)))
        if not apart.all():
            found[:, ~apart] = self._peaks(joints[~apart], [figure[~apart] for figure in peak])
        return found if any(map(np.ndim, places)) else found[:, 0]

    @cached_property
    def z(self):
        """The friction (N, n) of size one of each joint."""
        return np.concatenate([part.seen.filtered(path)
                               for part, path in zip(self.parts, self.paths)])

    def _peaks(self, joints, peak):
        """Return (N, K) of peaks that turn with all other friction, or of that alone."""
        if not peak:
            return self.z[:, joints]
        return np.concatenate([
            part.seen.filtered(path[..., joints] * left(part.seen.speeds[..., joints],
                                                        part.warmth[:, None, joints], *peak))
            for part, path in zip(self.parts, self.paths)])

    def _follow(self, places):
        """Return the friction (N, K) of Apart."""
        n = self.parts[0].warmth.shape[-1]
        return np.concatenate(lock_step(
            [(part.moved, part.seen.speeds, part.warmth[:, None], part.seen.dt[:, None])
             for part in self.parts],
            lambda numbers, rows: _filtered(places.tiled(len(numbers), n), *rows)))


def _bent(places, moved, speeds, warmth):
    """
    Yield the friction (ROWS, STEPS + 1, K) of Apart before the filter.

    moved (L, STEPS, n), speeds (L, STEPS + 1, n), warmth (L, 1, n).
    """
    joints = places.joints
    contacts = places.contacts(speeds[0][:, joints], warmth[0, 0, joints])
    for some in _slices(len(moved)):
        levels = places.levels(speeds[some][..., joints], warmth[some][..., joints])
        yield contacts.bend_along(*contacts.ways(moved[some][..., joints], levels))


def _slices(length):
    return [slice(start, start + ROWS) for start in range(0, length, ROWS)]


def _filtered(places, *rows):
    """Return the friction (L, K) of Apart; rows: of _bent, and dt (L, parts)."""
    *motion, dt = rows
    stages, start, out = None, 0, []
    for bent in _bent(places, *motion):
        # Parts side by side have their own times.
        bent = bent.reshape(*bent.shape[:2], dt.shape[1], -1).swapaxes(1, 2)
        if stages is None:
            stages = np.repeat(bent[0, :, :1], 3, axis=1)
        shown = filtered_along(stages, bent, dt[start:start + len(bent)])
        stages, start = shown[-1], start + len(bent)
        out.append(shown[:, :, 2].reshape(len(bent), -1))
    return np.concatenate(out)


def followed_together(parts, ways):
    """
    Yield, of each of the ways in which friction may turn, a list of the ShownAlong of each part.

    ways: `own` of ShownAlong. They are followed side by side, a few at a time.
    """
    for start in range(0, len(ways), WAYS):
        some = ways[start:start + WAYS]
        travels, plastic = (np.array(own) for own in zip(*some))
        paths = lock_step(
            [(part.moved, part.seen.speeds, *([] if part.levels is None else [part.levels]))
             for part in parts],
            lambda numbers, rows: _paths(len(numbers), travels, plastic, *rows))
        n = travels.shape[1]
        for k, own in enumerate(some):
            yield [ShownAlong((part,), own, (path[..., k * n:(k + 1) * n],))
                   for part, path in zip(parts, paths)]


def _paths(count, travels, plastic, moved, speeds, levels=None):
    """
    Return friction (L, STEPS + 1, count * k n) of parts side by side, in k ways each.

    In times its level, of those (L, STEPS + 1, n) that it bends up to.
    """
    k, n = travels.shape
    joints = np.tile(np.arange(count * n).reshape(count, 1, n), (1, k, 1)).ravel()
    first = begun(speeds[0, 1:])[joints]
    contacts = Contacts(*(np.tile(each.ravel(), count) for each in (travels, plastic)),
                        first if levels is None else first * levels[0, 0, joints])
    out = []
    for some in _slices(len(moved)):
        own = None if levels is None else levels[some][..., joints]
        bent = contacts.bend_along(*contacts.ways(moved[some][..., joints], own))
        out.append(bent if own is None else bent / own)
    return np.concatenate(out)


def shown_as_one(shown):
    """Return one ShownAlong of several whose friction turns alike."""
    return ShownAlong(tuple(part for one in shown for part in one.parts), shown[0].own,
                      tuple(path for one in shown for path in one.paths))


def shown_along(course, dt, warmth, own, messages=None):
    """
    Return ShownAlong one course (N, 2, STEPS, n); dt (N,) [s]; warmth (N, n) [K].

    own: as of ShownAlong; messages (N,), or None where the course has no noise.
    """
    messages = np.zeros(len(dt)) if messages is None else messages
    return next(followed_together(
        (ShownPart(SeenCourse(course, dt, messages), warmth),), [own]))[0]
