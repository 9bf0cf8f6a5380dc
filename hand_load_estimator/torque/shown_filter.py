"""The motion filter's three stages, for what is known at even moments within a sample."""

from functools import lru_cache

import numpy as np

from ..course import STEPS
from ..motion import filter_step

# Times between samples are rounded to this [s], so that jitter makes no end of filters.
ROUNDED = 1e-4


@lru_cache(maxsize=4096)
def _filter(count):
    """Return the filter over `count` ROUNDED: (3, 3), and (3, STEPS + 1) of inputs in between."""
    matrix, before, now = filter_step(max(count, 1) * ROUNDED / STEPS)
    gains, whole = np.zeros((3, STEPS + 1)), np.eye(3)
    for k in range(STEPS, 0, -1):
        gains[:, k - 1] += whole @ before
        gains[:, k] += whole @ now
        whole = whole @ matrix
    return whole, gains


def filtered(stages, values, dt):
    """Return the filter's stages (3, K) dt [s] on, under values (STEPS + 1, K)."""
    matrix, gains = _filter(round(dt / ROUNDED))
    return matrix @ stages + gains @ values


def filtered_along(stages, values, dt):
    """
    Return the filter's stages (L, parts, 3, k) after each of L samples of parts side by side.

    stages (parts, 3, k) before them; values (L, parts, STEPS + 1, k); dt (L, parts) [s].
    """
    counts, which = np.unique(np.round(dt / ROUNDED).astype(int), return_inverse=True)
    matrices, gains = (np.stack(those)[which.reshape(dt.shape)]
                       for those in zip(*map(_filter, counts.tolist())))
    out = gains @ values
    for matrix, row in zip(matrices, out):
        row += matrix @ stages
        stages = row
    return out
