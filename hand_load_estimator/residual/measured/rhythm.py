"""
Tell whether a residual rings, by windows of it that are judged by what the others show.

In a window the periodogram P_k of a random signal with spectrum c S_k has, at the best c, the
likelihood -n log mean(P / S) - sum log S (Whittle), whatever the amplitude in that window. Two
spectra are compared over the octaves around a frequency: a power law through the other windows'
mean beside it, and that with a peak as high as theirs. The frequency is that at which the other
windows stand out most, so that looking for it costs no evidence.
"""

from dataclasses import dataclass

import numpy as np

from ..tracing.candidate import SIGMAS

SECONDS = 10.0       # of a window
SLOWEST = 0.6        # [Hz] below it the motion itself has its power
LEAST_SHARE = 0.1    # of every joint's power: less is no account of what is left there
# What a motion makes has no larger a share of its power at the frequency than the motion has. Of a
# motion with this much at half the frequency it may have more.
MOTION = 0.9         # of the residual's share
PERIODIC = 0.8
# Of what is gained the recordings but the best do at least this share, if it rings in some only.
OTHERS = 0.25
# Bins on either side that belong to a peak; those of a Hann window are not independent.
HALF, DEPENDENT = 2, 1.5
# Of a joint's mean power: what is below it is rounding.
ROUNDING = 1e-12


@dataclass(frozen=True)
class Rhythm:
    """
    The frequency [Hz] at which values stand out most, and its scatter from window to window.

    share (k,): of each joint's power that is near it; own: the largest share of any joint's
    motion that may make it ring so; gains, owner (windows,) [nats]: of the likelihood of each
    window by the others, and the number of its recording.
    """

    frequency: float
    scatter: float
    share: np.ndarray
    own: float
    gains: np.ndarray
    owner: np.ndarray

    @property
    def gain(self):
        """All that is gained [nats]."""
        return float(self.gains.sum())

    @property
    def gain_std(self):
        """Its standard error [nats]."""
        return float(self.gains.std() * np.sqrt(len(self.gains)))

    def sure(self, needed):
        """Tell whether it gains `needed` [nats], beyond chance, and is no motion's."""
        least = self.share.min()
        return bool(self.gain >= needed and self._again()
                    and least > LEAST_SHARE and self.own < MOTION * least)

    def _again(self):
        """Tell whether the gain is beyond its standard error, or more than one recording's."""
        # A swing that only some motions set off gains very unequally, and still surely.
        best = max(self.gains[self.owner == k].sum() for k in np.unique(self.owner))
        return self.gain > SIGMAS * self.gain_std or self.gain - best > OTHERS * self.gain


def rhythm(values, motion, dt, owner):
    """
    Return the Rhythm of values (N, k), or None for recordings that cannot tell.

    motion (N, m): whatever of the arm's motion may make a residual: speeds and accelerations of
    all joints; dt (N,) [s]; owner (N,): number of the recording a row is of.
    """
    step = float(np.median(dt))
    size = int(round(SECONDS / step))
    slowest = max(int(np.ceil(SLOWEST * size * step)), 2 * HALF + 2)
    parts = [slice(first, first + size) for own in _runs(owner)
             for first in range(own.start, own.stop - size + 1, size)]
    if slowest >= (size // 2 + 1) // 2 or len(parts) < 3:
        return None
    power, moved = (np.array([_periodogram(x[part]) for part in parts]) for x in (values, motion))
    mean = power.mean(axis=(0, 1))
    if not (mean > 0.0).all():
        return None
    power = power / mean + ROUNDING
    peaks, gains = zip(*(_judged(power[k], np.delete(power, k, axis=0).mean(axis=0), slowest)
                         for k in range(len(parts))))
    peak = int(np.median(peaks))
    places = [_place(window, peak) / (size * step) for window in power.mean(axis=2)]
    return Rhythm(_place(power.mean(axis=(0, 2)), peak) / (size * step), float(np.std(places)),
                  _near(power, peak, HALF), _of_motion(moved, peak),
                  np.array(gains), owner[[part.start for part in parts]])


def ringing(values, motion, dt, owner, needed):
    """
    Return the Rhythm of those of values (N, k) that surely ring together, and their columns.

    None where none do. A joint that is restless for another reason is no reason to deny a swing
    that the others show: the one that rings least is left out until the rest is sure.
    """
    columns = list(range(values.shape[1]))
    while columns:
        found = rhythm(values[:, columns], motion, dt, owner)
        if found is None:
            return None
        if found.sure(needed):
            return found, columns
        del columns[int(np.argmin(found.share))]
    return None


def _runs(owner):
    """Return the slices of equal values in owner (N,)."""
    edges = np.r_[0, np.flatnonzero(np.diff(owner)) + 1, len(owner)]
    return [slice(a, b) for a, b in zip(edges[:-1], edges[1:])]


def _periodogram(part):
    """Return the power (K, k) of a window (M, k)."""
    part = (part - part.mean(axis=0)) * np.hanning(len(part))[:, None]
    return np.abs(np.fft.rfft(part, axis=0)) ** 2


def _judged(window, others, slowest):
    """Return the peak of the others (K, k) and what it gains in the window (K, k) [nats]."""
    tried = range(slowest, len(others) // 2)
    peak = max(tried, key=lambda k: _gained(others, *_around(others, k)))
    # What rings may pause: in half the windows, for all that is known before.
    gain = _gained(window, *_around(others, peak)) / DEPENDENT
    return peak, float(np.logaddexp(0.0, gain) - np.log(2.0))


def _around(power, k):
    """
    Return the bins (M,) within an octave of k, a power law and the same with a peak (M, joints).

    The law goes through what lies on either side of bins k - HALF to k + HALF
    of power (K, joints).
    """
    bins = np.arange(k // 2, min(2 * k, len(power) - 1) + 1)
    places, levels = np.log(bins / k)[:, None], np.log(power[bins])
    below, above = bins < k - HALF, bins > k + HALF
    (x0, y0), (x1, y1) = ((places[side].mean(), levels[side].mean(axis=0))
                          for side in (below, above))
    law = np.exp(y0 + (places - x0) / (x1 - x0) * (y1 - y0))
    near = ~below & ~above
    height = (power[bins[near]] / law[near]).mean(axis=0)
    return bins, law, np.where(near[:, None], np.maximum(height, 1.0), 1.0) * law


def _gained(power, bins, law, peaked):
    """Return how much likelier power (K, joints) is with the peak than without [nats]."""
    power = power[bins]
    return sum(np.sum(sign * (len(bins) * np.log((power / spectrum).mean(axis=0))
                              + np.log(spectrum).sum(axis=0)))
               for sign, spectrum in ((1.0, law), (-1.0, peaked)))


def _of_motion(power, k):
    """Return the largest share of a joint's motion (windows, K, m) that may ring at bin k."""
    # What a joint does to and fro with one frequency makes residuals with twice that.
    periodic = _near(power, round(k / 2), HALF // 2).max()
    return float(max(_near(power, k, HALF).max(), periodic if periodic > PERIODIC else 0.0))


def _near(power, k, half):
    """Return the share (joints,) of power (windows, K, joints) within `half` of bin k."""
    near = power[:, k - half:k + half + 1].sum(axis=(0, 1))
    return near / np.maximum(power.sum(axis=(0, 1)), 1e-300)


def _place(power, k):
    """Return the centre of the power (K,) near bin k."""
    near = np.arange(k - HALF, k + HALF + 1)
    return float((near * power[near]).sum() / power[near].sum())
