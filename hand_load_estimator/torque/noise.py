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

from functools import lru_cache
import math

import numpy as np

from .filtered_noise import noise_gain

_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
APART = 0.06             # [s]
# Samples of the running mean, and how many of them tell what one would that is independent.
_MEMORY, _ALIKE = 400, 4.0
# A knock is no noise: squares count up to so many times the mean, which leaves of noise's own that
# share.
_CLIP, _CLIPPED = 4.0, 0.9205
_UNEVEN = 0.5            # spacings that differ by more than this share are uneven
_PER_OCTAVE = 8          # steps of the spacing, so that jitter needs few gains
_SHORTEST = 1e-3         # [s] of a spacing
_ASSUMED = 5             # samples the assumed noise counts for at the start
_MOST = 8                # messages per sample told apart; more change little


@lru_cache(maxsize=1024)
def difference_gain(step, apart, messages):
    """
    Return E[(fourth difference)^2] / density [1/s] of white noise behind the motion filter.

    step: spacing of the samples, in _PER_OCTAVE steps from 20 ms; apart: so many of them;
    messages: per sample.
    """
    kernel = np.zeros((len(_DIFFERENCES) - 1) * apart + 1)
    kernel[::apart] = _DIFFERENCES
    return noise_gain(0.02 * 2.0 ** (step / _PER_OCTAVE), messages, kernel)


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
        (n,) bool; return the density (n,) [Nm^2 s]: what is measured, less its own deviation.
        """
        if self._spacing is not None and abs(dt - self._spacing) > _UNEVEN * self._spacing:
            # Differences are what they are taken for at even spacing only.
            self._last = []
        self._spacing = dt
        apart = max(1, round(APART / max(dt, _SHORTEST)))
        reach = (len(_DIFFERENCES) - 1) * apart + 1
        self._last = [*self._last[1 - reach:], difference]
        self._slid = np.where(slides, self._slid + 1, 0)
        density = np.where(self._count > 0, self._mean, self._variance * dt)
        told = self._slid >= reach
        if len(self._last) == reach and told.any():
            self._measure(density, _step(dt), apart, min(messages, _MOST), told)
        if not self._count.any():
            return density
        alike = 2.0 * _ALIKE / np.maximum(self._count, 2.0 * _ALIKE)
        return np.where(self._count > 0, self._mean / (1.0 + np.sqrt(alike)), density)

    def _measure(self, density, step, apart, messages, told):
        """Let the newest difference move a density (n,), of the joints told (n,) bool."""
        gain = difference_gain(step, apart, messages)
        square = _DIFFERENCES.dot(np.array(self._last[::apart])) ** 2 / gain
        self._count = np.minimum(self._count + told, _MEMORY)
        share = 1.0 / np.minimum(self._count + _ASSUMED, _MEMORY)
        counted = np.minimum(square, _CLIP * density) / _CLIPPED
        self._mean = np.where(told, density + share * (counted - density), density)


def _step(dt):
    return round(_PER_OCTAVE * math.log2(max(dt, _SHORTEST) / 0.02))
