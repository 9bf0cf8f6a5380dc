"""
How much of a torque difference is noise of its single samples.

The model file states the density of its residual at the rate it was identified at. A driver that
reports less often, or a noisier one, hands over more noise per second of data: white noise of
variance s^2 at spacing dt has the density s^2 dt. Fourth differences see hardly anything of a
motion, so their size tells that density while the arm works: on joints that slide. What friction
does to a joint that is held or turns around is no noise, and larger.

They are of samples APART from one another. Of successive ones they would be the size of what is
above 15 Hz, which is hardly torque: accelerations of heavy links there are encoder noise twice
differentiated, two to four times the white noise and nothing at all where a load shows.
"""

from bisect import bisect_left
from functools import lru_cache
import math

import numpy as np

from .filtered_noise import noise_gain

_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
_BACK = range(len(_DIFFERENCES) - 1, -1, -1)
# [s] between the samples of a difference, which then sees mostly 5 to 12 Hz. Of a driver whose
# samples do not come so close it is a multiple of theirs. Where they come unevenly each is the
# nearest, off by less than this share.
APART, _OFF = 0.06, 0.34
# Samples of the running mean, and how many of them (20 ms from one another) tell what one would
# that is independent.
_MEMORY, _ALIKE = 400, 4.0
# Fewer count as so many where chance is judged: a slow driver is noisy from the start.
_FEW = 32
# A knock is no noise: squares count up to so many times the mean, which leaves of noise's own that
# share.
_CLIP, _CLIPPED = 4.0, 0.9205
_PER_OCTAVE = 8          # steps of the spacing, so that jitter needs few gains
_SHORTEST = 1e-3         # [s] of a spacing
_ASSUMED = 2             # samples the assumed noise counts for at the start
_MOST = 24               # messages per spacing told apart; more change little


@lru_cache(maxsize=1024)
def difference_gain(step, messages):
    """
    Return E[(fourth difference)^2] / density [1/s] of white noise behind the motion filter.

    step: spacing of its samples, in _PER_OCTAVE steps from 20 ms; messages: per spacing.
    """
    return noise_gain(0.02 * 2.0 ** (step / _PER_OCTAVE), messages, _DIFFERENCES)


class SampleNoise:
    """
    Measure the white density of torque differences, per joint.

    rmse (n,) [Nm]: RMS of the filtered residual, assumed until measured; stated (n,) [Nm^2 s]:
    density that holds unless what is measured is more by its own deviation.
    """

    def __init__(self, rmse, stated):
        self._variance, self._stated = rmse ** 2, stated
        self._mean, self._count = np.zeros(len(rmse)), np.zeros(len(rmse))
        self.restart()

    def restart(self):
        """Begin the differences anew, as after a gap; what was measured stays."""
        self._times, self._rows, self._time = [], [], 0.0
        self._slid = np.zeros(len(self._variance))

    def update(self, difference, dt, messages, slides):
        """
        Take a filtered difference (n,) [Nm], its spacing [s] and messages, and which joints slide
        (n,) bool; return the density (n,) [Nm^2 s].
        """
        self._time += dt
        self._times.append(self._time)
        self._rows.append(difference)
        self._slid = (self._slid + dt) * slides
        density = np.where(self._count > 0, self._mean, self._variance * dt)
        chosen = self._spaced(max(dt, _SHORTEST))
        if chosen:
            since = self._time - self._times[chosen[0]]
            told = self._slid > since + 1e-9
            if told.any():
                spacing = since / (len(chosen) - 1)
                gain = _gain(spacing, messages * spacing / max(dt, _SHORTEST))
                left = _DIFFERENCES.dot([self._rows[k] for k in chosen])
                self._measure(density, left * left / gain, told)
        deviation = np.sqrt(2.0 * _ALIKE / np.maximum(self._count, _FEW))
        holds = (self._count > 0) & (self._mean < (1.0 + deviation) * self._stated)
        density = np.where(self._count > 0, self._mean, density)
        return np.where(holds, self._stated, np.maximum(density, self._stated))

    def _spaced(self, dt):
        """Return which five samples are about evenly spaced, oldest first, or nothing."""
        apart = APART if dt <= 0.5 * APART else dt * max(1, round(APART / dt))
        old = bisect_left(self._times, self._time - (len(_DIFFERENCES) - 0.5) * apart)
        del self._times[:old], self._rows[:old]
        chosen = [self._nearest(self._time - k * apart) for k in _BACK]
        gaps = [self._times[b] - self._times[a] for a, b in zip(chosen, chosen[1:])]
        return chosen if max(abs(gap - apart) for gap in gaps) <= _OFF * apart else []

    def _nearest(self, time):
        after = bisect_left(self._times, time)
        if after == len(self._times):
            return after - 1
        before = max(after - 1, 0)
        return before if time - self._times[before] < self._times[after] - time else after

    def _measure(self, density, square, told):
        """Let squared differences over their gain (n,) move a density, of the joints told."""
        self._count = np.minimum(self._count + told, _MEMORY)
        share = 1.0 / np.minimum(self._count + _ASSUMED, _MEMORY)
        counted = np.minimum(square, _CLIP * density) / _CLIPPED
        self._mean = np.where(told, density + share * (counted - density), density)


def _gain(spacing, messages):
    step = round(_PER_OCTAVE * math.log2(spacing / 0.02))
    return difference_gain(step, min(max(1, round(messages)), _MOST))
