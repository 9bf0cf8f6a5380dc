"""What plain functions foretell of a residual on blocks they were not fitted to, and chance."""

import numpy as np

# Neighbouring blocks are left out in different folds: what is slow in time is foretold too.
FOLDS = 6
# Noise is forgotten after so long [s]. The same residual with the signs of such pieces drawn at
# random follows nothing: of so many draws this share explains less than what is called chance.
MEMORY, DRAWS, CHANCE = 0.5, 100, 0.99


class Foretelling:
    """
    Functions tried on values (N,) [Nm], weighted by weights (N,), cut into blocks.

    dt (N,) [s]; starts (B,): first row of each block; beside (N, l): columns that are fitted with
    and without the function. All columns are in units of what their factors may be.
    """

    def __init__(self, values, weights, dt, starts, beside):
        self._total = float(weights.sum())
        blocks = np.split(np.arange(len(values)), starts[1:])
        folds = [[rows[weights[rows] > 0.0] for rows in blocks[k::FOLDS]] for k in range(FOLDS)]
        # Rows that count, fold by fold, each fold a row of pieces.
        self._order = np.concatenate([rows for fold in folds for rows in fold])
        ends = np.cumsum([sum(map(len, fold)) for fold in folds])
        self._folds = [slice(end - sum(map(len, fold)), end) for end, fold in zip(ends, folds)]
        self._pieces = [_pieces(dt[self._order[fold]]) for fold in self._folds]
        rng = np.random.default_rng(0)
        self._signs = [np.vstack([np.ones(len(first)), rng.choice((-1.0, 1.0), (
            DRAWS, len(first)))]) for first in self._pieces]
        self._roots = np.sqrt(weights[self._order])
        self._values = self._roots * values[self._order]
        self._beside = beside
        # Columns that fit noise are better left out.
        self._alone = np.maximum(self._told(beside), 0.0) if self._total else 0.0

    def explained(self, columns):
        """Return (mean square that columns (N, k) take off, what chance may give) [Nm^2]."""
        if not self._total or not columns.shape[1]:
            return np.nan, np.nan
        gains = (self._told(np.hstack([self._beside, columns])) - self._alone) / self._total
        return gains[0], max(float(np.quantile(gains[1:], CHANCE)), 0.0)

    def _told(self, columns):
        """Return (1 + DRAWS,): weighted square of the blocks that fits to others take off."""
        weighted = columns[self._order] * self._roots[:, None]
        pulled = weighted * self._values[:, None]
        gram = [weighted[fold].T @ weighted[fold] for fold in self._folds]
        pull = [signs @ np.add.reduceat(pulled[fold], first) if len(first)
                else np.zeros((1 + DRAWS, columns.shape[1]))
                for fold, first, signs in zip(self._folds, self._pieces, self._signs)]
        told = np.zeros(1 + DRAWS)
        whole, all_pull = sum(gram) + np.eye(columns.shape[1]), sum(pull)
        for own, outside in zip(gram, pull):
            theta = np.linalg.solve(whole - own, (all_pull - outside).T).T
            told += ((2.0 * outside - theta @ own) * theta).sum(axis=1)
        return told


def _pieces(dt):
    """Return the first rows of pieces of MEMORY, of rows that last dt (N,) [s]."""
    middles = np.cumsum(dt) - 0.5 * dt
    return np.flatnonzero(np.diff(middles // MEMORY, prepend=-1.0))
