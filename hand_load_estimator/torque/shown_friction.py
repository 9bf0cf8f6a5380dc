"""
Friction as the motion filter shows it: of the motion before the filter, and then filtered.

Torque is compared behind a low-pass (motion.py). What is smooth may be evaluated at the filtered
motion; friction that turns within a reversal may not: what lasts a few hundredths of a second is
spread over the filter's memory, and the filtered velocity is far from the one that it belongs to.
So friction is evaluated along the motion as it was measured (course.py, contacts.py). Then it is
passed through the filter.
"""

from dataclasses import dataclass

import numpy as np

from ..course import SHARES, STEPS
from ..effects.stribeck_curve import left
from ..motion import BANDWIDTH
from .contacts import Contacts

# A joint that is first seen this fast [rad/s] slides.
SLIDES = 0.02


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


def begun(speeds):
    """Return friction of size one (n,) that joints begin with; speeds (STEPS, n) first seen."""
    speed = speeds.mean(axis=0)
    return np.where(np.abs(speed) > SLIDES, np.sign(speed), 0.0)


def directions(first, moved):
    """Return the directions (STEPS + 1, n) in which joints turned last; first (n,) before that."""
    out = np.empty((STEPS + 1, len(first)))
    out[0] = first
    for k, way in enumerate(moved):
        out[k + 1] = np.where(way != 0.0, np.sign(way), out[k])
    return out


@dataclass(frozen=True, eq=False)
class Apart:
    """
    Friction of size one that turns over travels of its own, at K places.

    joints (K,), some of them several times; travels (K,) [rad], plastic (K,) of
    presliding.Turning; peak: arguments (K,) of stribeck_curve.left behind the warmth, none where
    it does not fall. The contacts bend up to what is left of a peak: where that comes back, they
    have to bend again.
    """

    joints: np.ndarray
    travels: np.ndarray
    plastic: np.ndarray
    peak: tuple

    def tiled(self, count, n):
        """Return the same of `count` arms of n joints side by side."""
        joints = np.concatenate([self.joints + k * n for k in range(count)])
        return Apart(joints, np.tile(self.travels, count), np.tile(self.plastic, count),
                     tuple(np.tile(figure, count) for figure in self.peak))

    def levels(self, speeds, warmth):
        """Return what is left of the peaks (..., K) at speeds (..., K), None for one."""
        return left(speeds, warmth, *self.peak) if self.peak else None

    def contacts(self, speeds, warmth):
        """Return the Contacts of joints that are first seen at speeds (STEPS + 1, K)."""
        first, levels = begun(speeds[1:]), self.levels(speeds[0], warmth)
        return Contacts(self.travels, self.plastic, first if levels is None else first * levels)
