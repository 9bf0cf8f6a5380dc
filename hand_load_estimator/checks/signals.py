"""Evenly sampled, smoothed signals of a recording, for looking at it afterwards (not causal)."""

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

# Enough for the motions of an arm; more only costs time.
HIGHEST_GRID_RATE = 125.0
SMOOTHING = 10.0
LONGEST_GAP = 0.2
# Where the two-sided filters see the end of the data.
EDGE = 0.4


@dataclass(frozen=True)
class Signals:
    """
    Signals on an even grid, samples of one piece without gaps.

    rate [Hz]; time (N,); q, v, a (N, n) from the measured position, smoothed with a two-sided
    filter; velocity, effort (N, n) as measured (NaN where not), resampled.
    """

    rate: float
    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray


def low_pass(values, rate, cut_off):
    """Return values (N, ...) after a two-sided low-pass [Hz]."""
    cut_off = min(cut_off, 0.4 * rate)
    return sosfiltfilt(butter(2, cut_off, fs=rate, output='sos'), values, axis=0)


def _longest_piece(time):
    """Return the slice of the longest stretch without a gap."""
    breaks = np.flatnonzero(np.diff(time) > LONGEST_GAP) + 1
    starts, ends = np.r_[0, breaks], np.r_[breaks, len(time)]
    longest = np.argmax(time[ends - 1] - time[starts])
    return slice(starts[longest], ends[longest])


def _usable(time, position):
    """Return the indices of samples with finite position and increasing stamps, as many as can."""
    usable = np.flatnonzero(np.isfinite(position).all(axis=1) & np.isfinite(time))
    return usable[_increasing(time[usable])]


def _increasing(values):
    """
    Return the indices of the longest strictly increasing subsequence of values (N,).

    One stamp far ahead is left out, not all that come after it.
    """
    ends, last, before = [], [], np.full(len(values), -1)
    for k, value in enumerate(values):
        place = bisect_left(ends, value)
        ends[place:place + 1] = [value]
        last[place:place + 1] = [k]
        before[k] = last[place - 1] if place else -1
    chain = []
    k = last[-1] if last else -1
    while k >= 0:
        chain.append(k)
        k = before[k]
    return np.array(chain[::-1], dtype=int)


def _resampled(grid, time, values):
    return np.column_stack([np.interp(grid, time, column) for column in values.T])


def even_signals(time, position, velocity, effort):
    """Return the Signals of the longest piece without gaps, or None when it is below 4 s."""
    index = _usable(time, position)
    if len(index) < 20:
        return None
    index = index[_longest_piece(time[index])]
    t = time[index]
    if len(index) < 20 or t[-1] - t[0] < 4.0:
        return None
    rate = min(1.0 / np.median(np.diff(t)), HIGHEST_GRID_RATE)
    grid = np.arange(t[0], t[-1], 1.0 / rate)
    q = low_pass(_resampled(grid, t, position[index]), rate, SMOOTHING)
    v = np.gradient(q, 1.0 / rate, axis=0)
    a = np.gradient(v, 1.0 / rate, axis=0)
    inner = slice(round(EDGE * rate), len(grid) - round(EDGE * rate))
    measured = _resampled(grid, t, velocity[index]), _resampled(grid, t, effort[index])
    return Signals(rate, grid[inner], q[inner], v[inner], a[inner],
                   measured[0][inner], measured[1][inner])
