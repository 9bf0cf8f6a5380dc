"""
How a learned torque difference does on recordings it has not seen, and how much of it counts.

A function that fits its own recordings may still be wrong on the next day's, joint by joint. What
is subtracted is therefore a share of its mean, the gain, that fits recordings left out; and what
that is worth is judged on recordings that neither the functions nor the gain have seen. (What is
learned of all recordings once, a process's kernel or a neural process's networks, has.)
"""

from dataclasses import dataclass

import numpy as np

from ..identification.residual_noise import density

# A single recording is cut into so many parts in time; what is left beside one left out is taken
# in so many turns at most, or many recordings would need the square of their number.
PARTS = 4


@dataclass(frozen=True)
class LeftOut:
    """
    How a function does on recordings it was not learned from, joint by joint (n,).

    gain [-]: the share of its mean, 0 to 1, that fits there; share [-]: the residual's
    low-frequency density less such a share of the mean, over the whole residual's, each recording
    with a gain found without it, 1 where nothing is subtracted; variance [scale^2]: mean variance
    about what the gain subtracts.
    """

    gain: np.ndarray
    share: np.ndarray
    variance: np.ndarray


def left_out(data, learn):
    """
    Return LeftOut of learn(rows (N,) bool) -> predict(inputs) -> mean, variance (N, n).

    Each recording in turn is left out; a single one is cut in time instead.
    """
    everything = np.ones(len(data.dt), dtype=bool)
    learn = _once(learn)
    parts = _parts(data.owner, everything)
    mean, variance = _answers(data, learn, everything, parts)
    gain, rest = _gain(data, mean, everything), np.empty_like(mean)
    for part in np.unique(parts):
        out = parts == part
        seen, _ = _answers(data, learn, ~out, _parts(data.owner, ~out, PARTS))
        rest[out] = data.difference[out] - _gain(data, seen, ~out) * mean[out]
    before, after = (density(residual, data.worth, data.owner, data.dt)
                     for residual in (data.difference, rest))
    share = np.where(gain > 0.0, after / np.maximum(before, 1e-12), 1.0)
    return LeftOut(gain, share,
                   (data.worth * unexplained(mean, variance, gain)).sum(axis=0)
                   / data.worth.sum(axis=0))


def unexplained(mean, variance, gain):
    """Return the mean square (..., n) by which a function expects to miss gain * mean."""
    return variance + ((1.0 - gain) * mean) ** 2


def _once(learn):
    """Return learn() that learns once from the same rows: two left out are so in either order."""
    learned = {}

    def remembered(rows):
        key = rows.tobytes()
        if key not in learned:
            learned[key] = learn(rows)
        return learned[key]
    return remembered


def _parts(owner, rows, most=None):
    """Return (N,) the part that each of rows (N,) bool is left out with; at most so many."""
    out = np.full(len(rows), -1)
    recordings, out[rows] = np.unique(owner[rows], return_inverse=True)
    if len(recordings) == 1:
        out[rows] = np.arange(rows.sum()) * PARTS // rows.sum()
    elif most:
        out[rows] %= most
    return out


def _answers(data, learn, rows, parts):
    """Return mean and variance (N, n), right in rows, by functions that saw no row's part."""
    mean, variance = np.zeros_like(data.difference), np.zeros_like(data.difference)
    for part in np.unique(parts[rows]):
        out = parts == part
        mean[out], variance[out] = learn(rows & ~out)(data.inputs[out])
    return mean, variance


def _gain(data, mean, rows):
    """
    Return the gain (n,) in [0, 1] of a mean (N, n) that fits the rows best, by a ridge.

    Beforehand it is 0 give or take 1: a mean too small to be told from noise hardly counts.
    """
    worth, difference, mean = data.worth[rows], data.difference[rows], mean[rows]
    fit, known = (worth * mean * difference).sum(axis=0), (worth * mean ** 2).sum(axis=0)
    return np.clip(fit / (known + 1.0), 0.0, 1.0)
