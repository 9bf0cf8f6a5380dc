"""
White noise behind the motion filter: how large it is, and how much of it steps between rows show.

A driver's noise is independent from message to message; variance s^2 at spacing h is the density
s^2 h. The filter joins messages by straight lines and smooths them: the noise of a row is partly
that of the row before, the more the closer they are. Both its size and that of differences follow
from what one message leaves in the rows after it, at any spacing and any messages per row.
"""

from functools import lru_cache
import math

import numpy as np

from ..motion import BANDWIDTH, filter_step

# What one message leaves is followed for so long [s]: e^-30 of it is left.
_FOLLOWED = 30.0 / BANDWIDTH
# Spacings are told apart to so much [s], so that jitter needs few gains.
_TICK = 1e-4
_ROW, _STEP = (1.0,), (-1.0, 1.0)


def noise_gain(spacing, messages, kernel):
    """
    Return E[(sum of kernel times successive rows)^2] / density [1/s] of filtered white noise.

    spacing [s] of the rows; messages: per row; kernel (k,): factors of k rows.
    """
    dt = spacing / messages
    matrix, before, now = filter_step(dt)
    # What one noisy message leaves in the filter's output at later messages.
    response, row, first = [now[2]], np.array([0.0, 0.0, 1.0]), matrix @ now + before
    for _ in range(messages + math.ceil(_FOLLOWED / dt)):
        response.append(row @ first)
        row = row @ matrix
    # ... and in the rows, for each place it may have between two of them.
    total = sum(float(np.sum(np.convolve(response[place::messages], kernel) ** 2))
                for place in range(messages))
    # Unit density is a variance of 1 / dt per message.
    return total / dt


def noise_floor(residual, dt, messages):
    """
    Return the RMS (n,) of the white noise in a residual (N, n) of the motion filter.

    dt [s], messages (N,): since the row before. Noise differs from one row to the next, structure
    hardly does; NaN rows are left out.
    """
    of_row, of_step = _gains(dt, messages)
    return np.sqrt(_per_expected(residual, of_step / of_row))


def white_density(residual, dt, messages):
    """Return the density (n,) [Nm^2 s] of that noise."""
    return _per_expected(residual, _gains(dt, messages)[1])


def _per_expected(residual, expected):
    """Return the squared steps (n,) of a residual (N, n) over what is expected of them (N,)."""
    steps = np.diff(residual, axis=0)
    known = np.isfinite(steps)
    # Not a mean of ratios: rows that nearly coincide tell next to nothing.
    return np.where(known, steps ** 2, 0.0).sum(axis=0) \
        / np.maximum((known * expected[1:, None]).sum(axis=0), 1e-300)


def _gains(dt, messages):
    """Return the gains (2, N) [1/s] of rows and of the steps to them from the rows before."""
    ticks = np.maximum(np.rint(dt / _TICK), 1.0)
    kinds, kind = np.unique(np.stack([ticks, messages], axis=1), axis=0, return_inverse=True)
    return np.array([_gains_of(*map(int, ticked)) for ticked in kinds])[kind.ravel()].T


@lru_cache(maxsize=4096)
def _gains_of(ticks, messages):
    return tuple(noise_gain(ticks * _TICK, messages, kernel) for kernel in (_ROW, _STEP))
