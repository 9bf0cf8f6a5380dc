"""
Contacts that bend: friction of size one, or of a level that falls with speed, along a path.

Up to what is left of the Stribeck peak (stribeck_curve.py) they bend as up to any level. Where it
comes back as a joint slows down, they have to bend again.
"""

import numpy as np

from ..course import STEPS
from ..effects.own_travel import BOTH
from .presliding import Turning

# Of a Stribeck peak less than this [-] is nothing.
LEAST_LEVEL = 1e-6
# Friction is never so far from zero [-].
FAR = 2.0


class Contacts:
    """
    Friction (K,) of size one that turns over travels (K,), or up to levels.

    plastic (K,): of presliding.Turning; friction (K,): where it begins.
    """

    def __init__(self, travels, plastic, friction):
        self._travels, self._turning = travels, Turning(plastic)
        # Of contacts that yield all the way many samples are as easy as one.
        yields = np.asarray(plastic) >= BOTH
        self._yielding, self._sprung = np.flatnonzero(yields), np.flatnonzero(~yields)
        self._turning_sprung = Turning(plastic[self._sprung])
        self.friction = friction

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
        out = _bent(self._turning.after, self.friction, *_towards(directions, levels), bends)
        self.friction = out[-1]
        return out[::len(bends) // STEPS]

    def bend_along(self, directions, bends, levels):
        """Return what `bend` does of N samples (N, ...), one after the other."""
        out = np.empty((len(bends), STEPS + 1, len(self.friction)))
        towards, inverse = _towards(directions, levels)
        some = self._yielding
        if len(some):
            out[..., some] = _clipped_along(self.friction[some], np.exp(-bends[..., some]),
                                            towards[..., some])
        some, every = self._sprung, bends.shape[1] // STEPS
        if len(some):
            friction = self.friction[some]
            for row, *steps in zip(out, towards[..., some], inverse[..., some],
                                   bends[..., some]):
                bent = _bent(self._turning_sprung.after, friction, *steps)
                row[:, some], friction = bent[::every], bent[-1]
        self.friction = out[-1, -1]
        return out


def _towards(directions, levels):
    """Return the friction that contacts bend towards, none where they stand, and one over it."""
    return (directions, directions) if levels is None else (
        directions * levels, directions / levels)


def _bent(after, friction, towards, inverse, bends):
    """Return friction (S + 1, K) as it was and after each of S steps; after: of Turning."""
    out, stands = np.empty((len(bends) + 1, len(friction))), not towards.all()
    out[0] = friction
    for k, (level, per_level, bend) in enumerate(zip(towards, inverse, bends)):
        turned = level - level * after(np.maximum(1.0 - per_level * friction, 0.0), bend)
        friction = np.where(level != 0.0, turned, friction) if stands else turned
        out[k + 1] = friction
    return out


def _clipped_along(friction, kept, towards):
    """
    Return bend_along of contacts that yield all the way; of a way to a level `kept` is left.

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
    before = np.empty_like(gain)
    for row, (scale, add, low, high) in enumerate(zip(*maps[-1])):
        before[row] = friction
        friction = np.minimum(np.maximum(scale * friction + add, low), high)
    return np.stack([np.clip(scale * before + add, low, high) for scale, add, low, high
                     in maps[::len(towards[0]) // STEPS]], axis=1)
