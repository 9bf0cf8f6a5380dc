"""
How far the torque model is to be trusted, told online from what it did not foretell.

A model says how wrong it may be; what happened to an arm since its identification it cannot know.
Two things tell while the arm moves, in pieces of change.py:

Heavy tails. Each direction in which the model may be wrong has a Student prior instead of a normal
one: its variance is what the posterior says the direction needs, v = (nu + n^2 + S) / (nu + 1),
never less than stated (one step of expectation maximisation per piece). A friction level ten
stated deviations off is then found, and not taken for a load.

Normalised innovations. For all else, every window of motion is compared with what the belief
before it foretells: with b the load's score of the window and S its covariance, b^T S^-1 b is the
rank of S on average where everything is as stated. What it is of that multiplies all variances.
"""

from collections import deque

import numpy as np

from .change import PIECE, WINDOWS as CHANGE_WINDOWS
from .information import as_stated, Information, posterior_of, Trust
from .positive_solve import unit

# Degrees of freedom of the tails.
TAILS = 4.0
# Windows, in pieces, that are compared; the worst of them counts.
WINDOWS = (2, 5, 10)
# Squares of agreement taken for granted, so that chance in the first windows widens nothing.
ASSUMED = 3.0
# What was compared longer ago than this much motion [s] fades.
MEMORY = 30.0
# A Student's 95 % over a normal's: 1 + this over the degrees of freedom.
STUDENT = 1.21
# The model does not explain the torques whose variances are so many times what it states.
MISFIT = 5.0
# Directions told less than this, in units of each parameter's own, are rounding.
LEAST_TOLD = 1e-9


class ModelTrust:
    """
    Follow the Trust in a torque model along pieces of Information.

    prior: LoadPrior; nuisances: number r of directions in which the model may be wrong.
    """

    def __init__(self, prior, nuisances):
        self._prior, self._nuisances = prior, nuisances
        self._fade = np.exp(-PIECE / MEMORY)
        start = posterior_of(Information(0, nuisances), prior, prior.mean)
        self._first = start.products, np.zeros(nuisances), _joint(
            start.products_covariance, unit(nuisances), np.zeros((nuisances, 10)))
        self.clear()

    def clear(self):
        """Trust the model as it states."""
        self._counts = np.zeros((3, len(WINDOWS)))
        self._past = deque([self._counts], maxlen=max(CHANGE_WINDOWS) + 2)
        self.restart()

    def restart(self):
        """Begin with other data; what was learnt of the model's agreement stays."""
        self._precision = as_stated(self._nuisances).precision
        self._windows = [_Window(self._first, 10 + self._nuisances) for _ in WINDOWS]
        self._renew()

    def begin_anew(self, pieces):
        """Begin with other data, of which the newest `pieces` were compared with the old belief."""
        known = list(self._past)
        self._counts = known[max(len(known) - 1 - pieces, 0)]
        self._past = deque([self._counts], maxlen=self._past.maxlen)
        self.restart()

    def state(self):
        """Return {name: array}: what resume() goes on from in another run."""
        return {'counts': self._counts.copy(), 'precision': self._precision.diagonal().copy()}

    def resume(self, counts, precision):
        """Go on from a state(): counts (3, lengths), precision (r,)."""
        self._counts = np.array(counts)
        self._past = deque([self._counts], maxlen=self._past.maxlen)
        self.restart()
        self._precision = np.diag(precision)
        self._renew()

    @property
    def misfit(self):
        """Why the model does not explain the torques, or an empty string."""
        factor = self.now.factor
        return '' if factor <= MISFIT else (
            f'torques differ {np.sqrt(factor):.1f} times as much as load and model explain; all '
            'intervals are wider by that')

    def factor_before(self, pieces):
        """Return the factor as it was so many pieces ago."""
        return _factor(list(self._past)[max(len(self._past) - 1 - pieces, 0)])

    def take(self, piece):
        """Take a piece of Information that has just ended; look() judges it."""
        for window in self._windows:
            window.add(piece)

    def look(self, information, start, tare=None):
        """
        Judge what came since the last look.

        information: all Information so far; start: shape (10,) to begin at; tare: as of
        posterior_of.
        """
        stated = Trust(self._precision)
        posterior = posterior_of(information, self._prior, start, tare=tare, trust=stated)
        inner = np.linalg.inv(information.inner(stated))
        slope = inner @ information.matrix[10:, :10]
        nuisance = information.nuisance_given(posterior.products, stated)
        joint = _joint(posterior.products_covariance, inner, slope)
        needed = (TAILS + nuisance ** 2 + joint.diagonal()[10:]) / (TAILS + 1.0)
        self._precision = np.diag(1.0 / np.maximum(needed, 1.0))
        self._judge((posterior.products, nuisance, joint))
        self._renew()

    def _judge(self, belief):
        """Compare the windows that are full, and begin others with a belief."""
        self._counts = self._counts * self._fade
        for k, (window, length) in enumerate(zip(self._windows, WINDOWS)):
            if window.pieces >= length:
                self._counts[:, k] += window.squares()
                self._windows[k] = _Window(belief, 10 + self._nuisances)
        self._past.append(self._counts)

    def _renew(self):
        self.now = Trust(self._precision, _factor(self._counts))


class _Window:
    """Pieces since a belief: products (10,), nuisances (r,), covariance (10 + r, 10 + r)."""

    def __init__(self, belief, size):
        self._mean = np.concatenate(belief[:2])
        self._covariance = belief[2]
        self._vector, self._matrix = np.zeros(size), np.zeros((size, size))
        self.pieces = 0

    def add(self, piece):
        """Add an Information."""
        self._vector += piece.vector
        self._matrix += piece.matrix
        self.pieces += 1

    def squares(self):
        """Return b^T S^-1 b, the rank of S, and 1 for the window."""
        rows = self._matrix[:10]
        b = self._vector[:10] - rows @ self._mean
        covariance = rows[:, :10] + rows @ self._covariance @ rows.T
        # Masses and moments of inertia differ by orders of magnitude.
        scale = 1.0 / np.sqrt(np.maximum(covariance.diagonal(), 1e-300))
        values, axes = np.linalg.eigh(covariance * np.outer(scale, scale))
        told = values > LEAST_TOLD
        return np.sum(((b * scale) @ axes[:, told]) ** 2 / values[told]), told.sum(), 1.0


def _joint(products_covariance, inner, slope):
    """
    Return the covariance (10 + r, 10 + r) of products and nuisances.

    inner (r, r): covariance of the nuisances for a known load, slope (r, 10): minus what they
    change by with it.
    """
    r = len(inner)
    out = np.empty((10 + r, 10 + r))
    cross = slope @ products_covariance
    out[:10, :10] = products_covariance
    out[10:, :10], out[:10, 10:] = -cross, -cross.T
    out[10:, 10:] = inner + cross @ slope.T
    return out


def _factor(counts):
    """
    Return the factor on variances of counts (3, lengths): squares, ranks, windows; at least 1.

    What so few windows tell is a Student's variance: its 95 % are wider than a normal's.
    """
    squares, ranks, windows = counts
    factor = (ASSUMED + squares) / (ASSUMED + ranks)
    student = 1.0 + STUDENT / (1.0 + windows)
    return max(1.0, float((1.0 + (factor - 1.0) * student ** 2).max()))
