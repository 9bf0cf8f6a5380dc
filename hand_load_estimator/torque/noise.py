"""
How much of a torque difference is noise of its single samples.

The model file states the density of its residual at the rate it was identified at. A driver that
reports less often, or a noisier one, hands over more noise per second of data: white noise of
variance s^2 at spacing dt has the density s^2 dt. Fourth differences see hardly anything of a
motion, so their size tells that density while the arm works: on joints that slide. What friction
does to a joint that is held or turns around is no noise, and larger.
"""

from functools import lru_cache
import math

import numpy as np

from .filtered_noise import noise_gain

_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
_MEMORY = 150            # samples of the running mean
# A knock is no noise: squares count up to so many times the mean.
_CLIP = 9.0
_UNEVEN = 0.5            # spacings that differ by more than this share are uneven
_PER_OCTAVE = 8          # steps of the spacing, so that jitter needs few gains
_SHORTEST = 1e-3         # [s] of a spacing
_ASSUMED = 5             # samples the assumed noise counts for at the start
_MOST = 8                # messages per sample told apart; more change little


@lru_cache(maxsize=1024)
def difference_gain(step, messages):
    """
    Return E[(fourth difference)^2] / density [1/s] of white noise behind the motion filter.

    step: spacing of the samples, in _PER_OCTAVE steps from 20 ms; messages: per sample.
    """
    return noise_gain(0.02 * 2.0 ** (step / _PER_OCTAVE), messages, _DIFFERENCES)


class SampleNoise:
    """
    Measure the white density of torque differences, per joint.

    rmse (n,) [Nm]: RMS of the filtered residual, assumed until measured.
    """

    def __init__(self, rmse):
        self._variance = rmse ** 2
        self._mean, self._count = np.zeros(len(rmse)), np.zeros(len(rmse))
        self.restart()

    def restart(self):
        """Begin the differences anew, as after a gap; what was measured stays."""
        self._last, self._spacing = [], None
        self._slid = np.zeros(len(self._variance))

    def update(self, difference, dt, messages, slides):
        """
        Take a filtered difference (n,) [Nm], its spacing [s] and messages, and which joints slide
        (n,) bool; return the density (n,) [Nm^2 s].
        """
        if self._spacing is not None and abs(dt - self._spacing) > _UNEVEN * self._spacing:
            # Differences are what they are taken for at even spacing only.
            self._last = []
        self._spacing = dt
        self._last = [*self._last[-4:], difference]
        self._slid = np.where(slides, self._slid + 1, 0)
        density = np.where(self._count > 0, self._mean, self._variance * dt)
        told = self._slid >= len(_DIFFERENCES)
        if len(self._last) == len(_DIFFERENCES) and told.any():
            step = round(_PER_OCTAVE * math.log2(max(dt, _SHORTEST) / 0.02))
            gain = difference_gain(step, min(messages, _MOST))
            square = _DIFFERENCES.dot(np.array(self._last)) ** 2 / gain
            self._count = np.minimum(self._count + told, _MEMORY)
            share = 1.0 / np.minimum(self._count + _ASSUMED, _MEMORY)
            moved = density + share * (np.minimum(square, _CLIP * density) - density)
            self._mean = density = np.where(told, moved, density)
        return density
