"""
What is left of a residual: noise, or structure? Told by what it remembers.

White noise behind the motion filter is forgotten within a tenth of a second, and so is the noise
of the measured acceleration, which is quicker. What still resembles itself later is structure.
That is the least of it: structure may be as quick as noise. The most of it is what is left beside
white noise as large as rows differ from one to the next; noise that was smoothed on its way,
before the filter, counts in there.
"""

from dataclasses import dataclass

import numpy as np

from ...torque.filtered_noise import noise_floor

# Lags [s] at which noise is forgotten and structure is looked for, and how finely.
FORGOTTEN, LATEST, STEP = 0.1, 0.5, 0.02
# The resemblance at a lag must be so many times its standard error over pieces so long [s], of
# which there are so many at least.
PIECE, SIGMAS, FEWEST = 0.25, 3.5, 8
# Structure that is not sure may be as large as so many standard errors; where that is more than
# this share of the variance, nothing is known of it.
PERHAPS, HIDDEN = 2.0, 0.18
# A resemblance is not told more exactly than this: of what is nearly all structure some is noise.
NEARLY_ALL = 0.99


@dataclass(frozen=True)
class Rest:
    """
    RMS (n,) [Nm] of a residual; what of it is noise: at most `most`, at least `noise` if white.

    NaN: not known, because there is too little of it.
    """

    rms: np.ndarray
    noise: np.ndarray
    most: np.ndarray

    @property
    def least_structure(self):
        """Share (n,) of the variance that is surely structure."""
        return 1.0 - (self.most / np.maximum(self.rms, 1e-12)) ** 2


def rest_of(residual, dt, messages, owner):
    """
    Return the Rest of a residual (N, n) [Nm], NaN in rows that do not count.

    dt [s], messages, owner (N,): since the row before, of joint states, recording of each row.
    """
    count = np.isfinite(residual).sum(axis=0)
    square = np.where(count > 0, np.nansum(residual ** 2, axis=0), np.nan) / np.maximum(count, 1)
    products, pairs = _products(residual, dt, owner)
    share, hidden = _remembered(products / square, pairs)
    rms = np.sqrt(square)
    known = (share > 0.0) | (hidden < HIDDEN)
    most = np.where(known, rms * np.sqrt(1.0 - share), np.nan)
    least = rms * np.sqrt(1.0 - np.where(share > 0.0, share, known * np.minimum(hidden, 1.0)))
    # Noise of the acceleration differs more from row to row than white noise of its size.
    return Rest(rms, np.minimum(least, noise_floor(residual, dt, messages)), most)


def _remembered(products, pairs):
    """
    Return (share (n,) of the variance that surely resembles itself later, what may unnoticed).

    products, pairs (K, L, n): of rows a lag apart, summed over pieces, and how many; in units of
    the variance. The largest lag counts: nothing resembles its past more than itself.
    """
    total = np.maximum(pairs.sum(axis=0), 1.0)
    mean = products.sum(axis=0) / total
    spread = np.sqrt(((products - pairs * mean) ** 2).sum(axis=0)) / total
    error = np.where((pairs > 0.0).sum(axis=0) >= FEWEST, spread, np.inf)
    # Lags between those of the rows have hardly a pair.
    seen = total >= 0.5 * total.max(axis=0)
    share = np.where(seen & (np.abs(mean) > SIGMAS * error), np.abs(mean), 0.0).max(axis=0)
    hidden = PERHAPS * np.where(seen, error, 0.0).sum(axis=0) / seen.sum(axis=0)
    return np.minimum(share, NEARLY_ALL), hidden


def _products(residual, dt, owner):
    """Return sums (K, L, n) over pieces of products of rows about a lag apart, their numbers."""
    lags = 1 + round((LATEST - FORGOTTEN) / STEP)
    time, known = np.cumsum(dt), np.isfinite(residual)
    values, piece = np.where(known, residual, 0.0), (time // PIECE).astype(int)
    shape = (piece[-1] + 1, lags)
    products, pairs = (np.zeros((shape[0] * shape[1], residual.shape[1])) for _ in range(2))
    for shift in range(1, len(time)):
        apart = time[shift:] - time[:-shift]
        if apart.min() > LATEST:
            break
        lag = np.rint((apart - FORGOTTEN) / STEP).astype(int)
        rows = np.flatnonzero((owner[shift:] == owner[:-shift]) & (lag >= 0) & (lag < lags))
        cell = piece[rows] * shape[1] + lag[rows]
        np.add.at(products, cell, values[rows] * values[rows + shift])
        np.add.at(pairs, cell, known[rows] & known[rows + shift])
    return products.reshape(*shape, -1), pairs.reshape(*shape, -1)
