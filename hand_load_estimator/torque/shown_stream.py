"""Friction as the motion filter shows it (shown_friction.py), sample by sample."""

import numpy as np

from ..course import Ways
from ..effects.stribeck_curve import left
from .contacts import Contacts
from .shown_filter import filtered
from .shown_friction import Apart, begun, directions


class _ApartStream:
    """Follow Apart sample by sample."""

    def __init__(self, places):
        self._places, self._contacts = places, None

    def update(self, moved, speeds, warmth, dt, _):
        """Return friction (K,) after a sample; arguments as of ShownStream's motion."""
        moved, speeds, warmth = (part[..., self._places.joints]
                                 for part in (moved, speeds, warmth))
        if self._contacts is None:
            self._contacts = self._places.contacts(speeds, warmth)
            self._stages = np.tile(self._contacts.friction, (3, 1))
        ways = self._contacts.ways(moved, self._places.levels(speeds, warmth))
        self._stages = filtered(self._stages, self._contacts.bend(*ways), dt)
        return self._stages[2]


class _PeakStream:
    """Follow peaks that turn with all other friction of their joints."""

    def __init__(self, joints, peak):
        self._joints, self._peak, self._stages = joints, peak, None

    def update(self, _, speeds, warmth, dt, path):
        """Return friction (K,) after a sample; arguments as of ShownStream's motion."""
        bent = path[:, self._joints] * left(speeds[:, self._joints], warmth[self._joints],
                                            *self._peak)
        if self._stages is None:
            self._stages = np.tile(bent[0], (3, 1))
        self._stages = filtered(self._stages, bent, dt)
        return self._stages[2]


class ShownStream:
    """
    Friction sample by sample: of all joints, and of all places that are asked for.

    own: travels [rad] and plastic [-] (n,) over which each joint's friction turns; level: the
    ContactLevel of the joints, None for none. After `at`: moved (STEPS, n) [rad], the joints' ways
    within the sample, as short as they would be at the reference temperature; z (n,), and at_once
    (n,): what z would be of contacts that turn at once.
    """

    def __init__(self, own, level=None):
        self._own, self._level = own, level
        self.restart()

    def restart(self):
        """Forget the path."""
        self._places, self._ways = {}, None

    def at(self, course, dt, warmth, messages):
        """
        Return shown(joints, travels, plastic, *peak) of EffectInput after a course (2, STEPS, n).

        dt [s] long, of so many messages; warmth (n,) [K].
        """
        q, v = course
        if begins := self._ways is None:
            first = begun(v)
            self._ways, self._speed, self._direction = Ways(q[0]), v[0], first
            self._stages = np.tile(first, (3, 2))
        self.moved, levels = self._ways.along(q, dt, messages), None
        speeds, self._speed = np.concatenate([self._speed[None], v]), v[-1]
        if self._level is not None:
            self.moved = self.moved / self._level.warmed(warmth)
            levels = self._level.fallen(speeds, warmth)
        if begins:
            self._contacts = Contacts(*self._own, first if levels is None else first * levels[0])
        path = self._contacts.bend(*self._contacts.ways(self.moved, levels))
        if levels is not None:
            path = path / levels
        turned = directions(self._direction, self.moved)
        self._direction = turned[-1]
        self._stages = filtered(self._stages, np.concatenate([path, turned], axis=1), dt)
        self.z, self.at_once = self._stages[2].reshape(2, -1)
        motion, known = (self.moved, speeds, warmth, dt, path), {}

        def shown(*places):
            key = tuple(place.tobytes() if isinstance(place, np.ndarray) else place
                        for place in places)
            if key not in known:
                if key not in self._places:
                    self._places[key] = self._followed(places)
                known[key] = self._together(self._places[key], motion)
            return known[key] if any(map(np.ndim, places)) else known[key][:, 0]
        return shown

    @staticmethod
    def _followed(places):
        """Return (rows (K,), what follows them) of places apart and others, or joints: z's."""
        joints, travels, plastic, *peak = np.broadcast_arrays(*map(np.atleast_1d, places))
        apart, out = np.isfinite(travels), []
        if apart.any():
            out.append((apart, _ApartStream(Apart(
                joints[apart], travels[apart], plastic[apart],
                tuple(figure[apart] for figure in peak)))))
        if not apart.all():
            rest = ~apart
            out.append((rest, _PeakStream(joints[rest], [figure[rest] for figure in peak])
                        if peak else joints[rest]))
        return out

    def _together(self, followed, motion):
        out = np.empty((1, len(followed[0][0])))
        for rows, stream in followed:
            out[0, rows] = self.z[stream] if isinstance(stream, np.ndarray) \
                else stream.update(*motion)
        return out
