"""
How much of a torque difference is noise of its single samples.

The model file states the density of its residual at the rate it was identified at. A driver that
reports less often, or a noisier one, hands over more noise per second of data: white noise of
variance s^2 at spacing dt has the density s^2 dt. Fourth differences see hardly anything of a
motion, so their size tells that density while the arm works.
"""

from functools import lru_cache

import numpy as np

from .motion import filter_step

_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
_MEMORY = 150            # samples of the running mean
# A reversal's step of friction is no noise: squares count up to so many times the mean.
_CLIP = 9.0
_UNEVEN = 0.5            # spacings that differ by more than this share are uneven
_ASSUMED = 5             # samples the assumed noise counts for at the start
_MOST = 8                # messages per sample told apart; more change little


@lru_cache(maxsize=256)
def difference_gain(spacing, messages):
    """Return E[(fourth difference)^2] / density [1/s] of white noise behind the motion filter."""
    dt = spacing / messages
    matrix, before, now = filter_step(dt)
    length, total = messages * 60, 0.0
    # What one noisy message leaves in the samples, for each place it may have between two.
    for phase in range(messages):
        state, last, out = np.zeros(3), 0.0, []
        for k in range(length):
            value = 1.0 if k == phase else 0.0
            state = matrix @ state + before * last + now * value
            last = value
            if k % messages == messages - 1:
                out.append(state[2])
        total += float(np.sum(np.convolve(out, _DIFFERENCES) ** 2))
    # Unit density is a variance of 1 / dt per message.
    return total / dt


class SampleNoise:
    """
    Measure the white density of torque differences, per joint.

    rmse (n,) [Nm]: RMS of the filtered residual, assumed until measured.
    """

    def __init__(self, rmse):
        self._variance = rmse ** 2
        self._mean, self._count = None, _ASSUMED
        self.restart()

    def restart(self):
        """Begin the differences anew, as after a gap; what was measured stays."""
        self._last, self._spacing = [], None

    def update(self, difference, dt, messages):
        """
        Take a filtered difference (n,) [Nm], its spacing [s] and messages; return (n,) [Nm^2 s].
        """
        if self._mean is None:
            self._mean = self._variance * dt
        if self._spacing is not None and abs(dt - self._spacing) > _UNEVEN * self._spacing:
            # Differences are what they are taken for at even spacing only.
            self._last = []
        self._spacing = dt
        self._last = [*self._last[-4:], difference]
        if len(self._last) == 5:
            gain = difference_gain(max(round(dt, 3), 1e-3), min(messages, _MOST))
            square = (_DIFFERENCES @ np.array(self._last)) ** 2 / gain
            self._count = min(self._count + 1, _MEMORY)
            self._mean = self._mean + (np.minimum(square, _CLIP * self._mean)
                                       - self._mean) / self._count
        return self._mean
