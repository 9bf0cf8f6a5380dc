"""Means of rows over blocks of time: what does not average out of a residual, and how slowly."""

import numpy as np

# Lengths [s] of blocks, and how many there are to be at least for a length to tell anything.
LENGTHS = (0.06, 0.2, 0.5, 1.0)
FEWEST = 8


def all_blocks(weights, owner, dt):
    """Yield the Blocks of each of LENGTHS of which there are enough; dt (N,) [s] of the rows."""
    period = float(np.median(dt))
    for length in LENGTHS:
        size = max(1, round(length / period))
        if len(weights) // size < FEWEST:
            return
        yield Blocks(weights, owner, size, period)


class Blocks:
    """
    B blocks of `size` rows, one after the other; length [s]: of each.

    weights (N, n): of rows, by joint; owner (N,): of what a row is part; a block that is part of
    two counts for nothing.
    """

    def __init__(self, weights, owner, size, period):
        self.length = size * period
        self._count, self._size = len(weights) // size, size
        self._weights = self._cut(weights)
        self._total = self._weights.sum(axis=1)
        own = self._cut(owner)
        self._worth = self._total * (own == own[:, :1]).all(axis=1)[:, None]

    def _cut(self, rows):
        return rows[:self._count * self._size].reshape(self._count, self._size, *rows.shape[1:])

    def first(self, rows):
        """Return the first of each block's rows (N,), (B,)."""
        return self._cut(rows)[:, 0]

    def means(self, values):
        """Return the means (B, n) of values (N, n), each joint's by its weights."""
        return (self._weights * self._cut(values)).sum(axis=1) / np.maximum(self._total, 1e-30)

    def means_for(self, joint, values):
        """Return the means (B, k) of values (N, k) by the weights of a joint."""
        return np.einsum('bs,bsk->bk', self._weights[:, :, joint], self._cut(values)) \
            / np.maximum(self._total[:, joint, None], 1e-30)

    def average(self, values, share=1.0):
        """Return the average (n,) of values (B, n); share (B, n): of what each counts."""
        worth = self._worth * share
        return (worth * values).sum(axis=0) / np.maximum(worth.sum(axis=0), 1e-30)
