"""
Tell a changed load from noise: the evidence that recent data come from another load.

Recent information (L_r, v_r) is compared with what the older belief x ~ N(x_o, S_o) predicts:
z = v_r - L_r x_o has covariance L_r + L_r S_o L_r when nothing changed. A change d of the load
adds L_r d. With a prior N(0, P) on d the log Bayes factor of changed against unchanged is
b^T (A + P^-1)^-1 b / 2 - log det(I + P A) / 2, where A and b are the information about d in z.
"""

from collections import deque

import numpy as np

from .information import Information

# Recent data are kept in pieces of this length [s of motion] ...
PIECE = 0.1
# ... and tested over the last so many of them.
WINDOWS = (3, 10)
# Evidence needed: a log Bayes factor at which chance needs e^-25 of luck. Model error is not
# chance, hence so high.
EVIDENCE = 25.0


def log_bayes_factor(recent, older_mean, older_covariance, change):
    """
    Return the log Bayes factor of a changed load.

    recent: Information; older_mean (d,), older_covariance (d, d): belief without it; change
    (10, 10): covariance of what a load may change by.
    """
    z = recent.vector - recent.matrix @ older_mean
    d = len(z)
    solved = np.linalg.solve(np.eye(d) + recent.matrix @ older_covariance,
                             np.column_stack([z, recent.matrix[:, :10]]))[:10]
    b, a = solved[:, 0], solved[:, 1:]
    inflated = np.eye(10) + a @ change
    quadratic = b @ change @ np.linalg.solve(inflated, b)
    return 0.5 * (quadratic - np.linalg.slogdet(inflated)[1])


class RecentData:
    """The newest pieces of information, apart from the older sum."""

    def __init__(self, n, nuisances):
        self._size = (n, nuisances)
        self.clear()

    def clear(self):
        """Forget everything."""
        self.older = Information(*self._size)
        self.pieces = deque()
        self._open, self._length = Information(*self._size), 0.0

    def add(self, columns, difference, weights, dt, moving):
        """Add a sample; returns True when a piece of motion was completed."""
        self._open.add_rows(columns, difference, weights)
        self._length += dt if moving else 0.0
        if self._length < PIECE:
            return False
        self.pieces.append(self._open)
        self._open, self._length = Information(*self._size), 0.0
        if len(self.pieces) > max(WINDOWS):
            self.older.add(self.pieces.popleft())
        return True

    def total(self):
        """Return the Information of everything kept."""
        out = self.older.plus(self._open)
        for piece in self.pieces:
            out.add(piece)
        return out

    def split(self, count):
        """Return (older, recent) with the last `count` pieces as recent, or None."""
        if len(self.pieces) <= count:
            return None
        older, recent = self.older.plus(Information(*self._size)), Information(*self._size)
        for k, piece in enumerate(self.pieces):
            (recent if k >= len(self.pieces) - count else older).add(piece)
        return older, recent

    def keep_last(self, count):
        """Drop all but the last `count` pieces."""
        self.older = Information(*self._size)
        while len(self.pieces) > count:
            self.pieces.popleft()

    def forget(self, factor):
        """Fade the older sum by a factor."""
        self.older.scale(factor)
