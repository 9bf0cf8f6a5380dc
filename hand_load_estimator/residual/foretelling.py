"""How much of a residual plain functions foretell on blocks they were not fitted to, and chance."""

import numpy as np

# Neighbouring blocks are left out in different folds: what is slow in time is foretold too.
FOLDS = 6
# Noise is forgotten after so many samples (half a second). The same residual with the signs of
# such pieces drawn at random follows nothing: of so many draws this share explains less than what
# is called chance.
MEMORY, DRAWS, CHANCE = 25, 100, 0.99


class Foretelling:
    """
    Functions tried on values (N,) [Nm], weighted by weights (N,), cut into blocks.

    starts (B,): first row of each block; beside (N, l): columns that are fitted with and without
    the function. All columns are in units of what their factors may be.
    """

    def __init__(self, values, weights, starts, beside):
        self._values, self._weights, self._beside = values, weights, beside
        self._total = float(weights.sum())
        blocks = np.split(np.arange(len(values)), starts[1:])
        self._folds = [[piece for rows in blocks[fold::FOLDS]
                        for piece in np.array_split(rows, max(len(rows) // MEMORY, 1))]
                       for fold in range(FOLDS)]
        rng = np.random.default_rng(0)
        self._signs = [np.vstack([np.ones(len(pieces)), rng.choice((-1.0, 1.0), (
            DRAWS, len(pieces)))]) for pieces in self._folds]
        # Columns that fit noise are better left out.
        self._alone = np.maximum(self._told(beside), 0.0)

    def explained(self, columns):
        """Return (mean square that columns (N, k) take off, what chance may give) [Nm^2]."""
        if not self._total or not columns.shape[1]:
            return np.nan, np.nan
        gains = (self._told(np.hstack([self._beside, columns])) - self._alone) / self._total
        return gains[0], max(float(np.quantile(gains[1:], CHANCE)), 0.0)

    def _told(self, columns):
        """Return (1 + DRAWS,): weighted square of the blocks that fits to others take off."""
        weighted = columns * self._weights[:, None]
        pulled = weighted * self._values[:, None]
        gram, moment = [], []
        for pieces, signs in zip(self._folds, self._signs):
            rows = np.concatenate(pieces)
            gram.append(weighted[rows].T @ columns[rows])
            moment.append(signs @ np.array([pulled[piece].sum(axis=0) for piece in pieces]))
        told = np.zeros(1 + DRAWS)
        whole, pull = sum(gram) + np.eye(columns.shape[1]), sum(moment)
        for own, outside in zip(gram, moment):
            theta = np.linalg.solve(whole - own, (pull - outside).T).T
            told += ((2.0 * outside - theta @ own) * theta).sum(axis=1)
        return told
