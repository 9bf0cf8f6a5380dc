"""Recordings that are noisier than those a model was made from, or come less often."""

import numpy as np

from ...torque.filtered_noise import noise_gain

# Means over so long [s] and their second differences see hardly anything of a motion, and nothing
# of what encoders do to accelerations above 10 Hz.
APART, _DIFFERENCES = 0.06, (1.0, -2.0, 1.0)
# What a model lacks comes with motion, noise is always there: the quietest quarter of pieces so
# long [s] tells. Of noise alone it is below this share of all.
PIECE, QUIET, _SHARE = 1.0, 0.25, 0.65
# Median of the square of a normal variable: noise makes most of the steps from row to row, while
# a structure that jumps makes few large ones.
_MEDIAN = 0.455
# Up to so many times as dense as stated noise counts as stated: what is left unexplained is in it.
NOISIER = 3.5


def times_noisier(residual, dt, messages, stated):
    """
    Return how many times as dense (n,) as stated (n,) [Nm^2 s] a recording's noise is.

    residual (N, n) [Nm]: what nothing explains, behind the motion filter; dt [s], messages (N,):
    since the row before. A driver that reports less often hands over more noise per second of
    data. 1 where it is as stated, or too short to tell.
    """
    spacing, each = float(np.median(dt)), max(1, round(float(np.median(messages))))
    mean, rows = max(1, round(APART / spacing)), max(1, round(PIECE / spacing))
    kernel = np.repeat(_DIFFERENCES, mean) / mean
    if len(residual) < len(kernel) + rows:
        return np.ones(len(stated))
    left = np.stack([np.convolve(column, kernel, 'valid') for column in residual.T], axis=1)
    pieces = left[:len(left) // rows * rows].reshape(-1, rows, len(stated))
    quiet = np.quantile((pieces ** 2).mean(axis=1), QUIET, axis=0) / (
        _SHARE * noise_gain(spacing, each, tuple(kernel)))
    usual = np.median(np.diff(residual, axis=0) ** 2, axis=0) / (
        _MEDIAN * noise_gain(spacing, each, (-1.0, 1.0)))
    told = np.minimum(quiet, usual)
    return np.where(told > NOISIER * stated, told / stated, 1.0)
