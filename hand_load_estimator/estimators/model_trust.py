"""
How far the torque model is to be trusted, told online from what it did not foretell.

A model says how wrong it may be; what happened to an arm since its identification it cannot know.
Two things tell while the arm moves, in pieces of change.py:

Heavy tails. Each direction in which the model may be wrong has a Student prior instead of a normal
one: its variance is what the posterior says the direction needs, v = (nu + n^2 + S) / (nu + 1),
never less than stated (one step of expectation maximisation per LOOK pieces). A friction level ten
stated deviations off is then found, and not taken for a load.

Normalised innovations. For all else, every window of motion is compared with what the belief
before it foretells: with b the load's score of the window and S its covariance, b^T S^-1 b is the
rank of S on average where everything is as stated. What it is of that multiplies all variances.

The load is any vector of products here, far beyond what a load of the robot may be: a prior in
shape parameters is curved, and would itself be what the data contradict.
"""

from collections import deque

import numpy as np

from ..identification.load_agreement import normalised_square
from .change import PIECE
from .information import as_stated, Information, Trust

# Degrees of freedom of the tails. With one, what ails an arm is found sooner than with four, and
# on healthy development arms intervals were the same (doc/method.md).
TAILS = 1.0
# Prior standard deviations beyond the prior's mean: as heavy, and as far away, is any load.
ANY_LOAD = 3.0
# Windows, in pieces, that are compared; the worst of them counts. Every so many pieces is looked.
WINDOWS, LOOK = (4, 8, 16), 2
# Squares of agreement taken for granted, so that chance in the first windows widens nothing.
ASSUMED = 3.0
# What was compared longer ago than this much motion [s] fades.
MEMORY = 30.0
# Whether a load has changed is asked with the factor of so many pieces ago: a change that is not
# noticed yet looks like a model that does not foretell.
BEFORE = 34
# Innovations below this share of what is stated, in which 1 is exactly as stated: surely none of
# the joints ails. Models whose doubt is wide say so of healthy arms; a model that is exact hardly
# ever does, and asks the joints first.
FORETOLD = 0.9
# Up to this factor on what is stated a model is taken to be as it states.
AS_STATED = 2.0
# A Student's 95 % over a normal's: 1 + this over the degrees of freedom.
STUDENT = 1.21
# The model does not explain the torques whose variances are so many times what it states.
MISFIT = 5.0


class ModelTrust:
    """
    Follow the Trust in a torque model along pieces of Information.

    prior: LoadPrior; nuisances: number r of directions in which the model may be wrong; n joints
    whose torque constants may be off by a share gain_doubt (n = 0: none).
    """

    def __init__(self, prior, nuisances, n=0, gain_doubt=0.0):
        self._size, self._gain_doubt = (n, nuisances), gain_doubt
        self._fade = np.exp(-LOOK * PIECE / MEMORY)
        self._any_load = any_load(prior)
        self._begin(np.zeros((10, 10)))
        self.clear()

    def _begin(self, tare):
        """Believe in any load; tare (10, 10): covariance of what was declared zero."""
        self._load_precision = np.linalg.inv(self._any_load + tare)

    def clear(self):
        """Trust the model as it states."""
        self._know(np.zeros((3, len(WINDOWS))))
        self.restart()

    def restart(self, tare=None):
        """
        Begin with other data; how well the model foretold stays.

        tare: covariance (10, 10) of what was declared zero, None where that is as it was.
        """
        if tare is not None:
            self._begin(tare)
        self._precision = as_stated(self._size[1]).precision
        # What nothing was measured before has nothing to be compared with.
        self.drop_windows()
        self._renew()

    def drop_windows(self):
        """Forget what was to be compared: the newest of it was no data of the load."""
        self._windows, self._waiting = [None] * len(WINDOWS), LOOK - 1

    def begin_anew(self, pieces):
        """Begin with other data; the newest `pieces` of it were compared with the old belief."""
        self._know(self._counts_before(pieces))
        self.restart()

    def state(self):
        """Return {name: array}: what resume() goes on from in another run."""
        return self.state_before(0)

    def state_before(self, pieces):
        """Return the state() in which the newest `pieces` were not compared yet."""
        return {'counts': self._counts_before(pieces).copy(),
                'precision': self._precision.diagonal().copy()}

    def resume(self, counts, precision, tare=None):
        """Go on from a state(): counts (3, lengths), precision (r,); tare: as of restart."""
        self._know(np.array(counts))
        self.restart(tare)
        self._precision = np.diag(precision)
        self._renew()

    @property
    def misfit(self):
        """Why the model does not explain the torques, or an empty string."""
        factor = self.now.factor
        return '' if factor <= MISFIT else (
            f'torques differ {np.sqrt(factor):.1f} times as much as load and model explain')

    def factor_before(self):
        """Return the factor as it was before what a change of load may have brought."""
        return _factor(self._counts_before(BEFORE))

    def foretold_before(self):
        """Tell whether torques were foretold better than stated, as factor_before counts."""
        return bool((_shares(self._counts_before(BEFORE)) < FORETOLD).all())

    def as_stated_before(self):
        """Tell whether torques were foretold about as well as stated, as factor_before counts."""
        counts = self._counts_before(BEFORE)
        return bool(counts[2].any() and _factor(counts) <= AS_STATED)

    def take(self, piece):
        """Take a piece of Information that has just ended; look() judges it."""
        self._waiting += 1
        for window in filter(None, self._windows):
            window.information.add(piece)
            window.pieces += 1

    def look(self, information):
        """
        Judge what came since the last look, if LOOK pieces did; information: all there is so far.
        """
        if self._waiting < LOOK:
            return
        self._waiting = 0
        precision = information.matrix.copy()
        precision[:10, :10] += self._load_precision
        precision[10:, 10:] += self._precision
        covariance = np.linalg.inv(precision)
        mean = covariance @ information.vector
        needed = (TAILS + mean[10:] ** 2 + covariance.diagonal()[10:]) / (TAILS + 1.0)
        self._precision = np.diag(1.0 / np.maximum(needed, 1.0))
        # What each joint's torque constant moves the mean by.
        moved = covariance @ (information.by_joint @ mean[:10]).T
        self._judge((mean, covariance, moved))
        self._renew()

    def _judge(self, belief):
        """Compare the windows that are full, and begin others with a belief."""
        counts = self._counts * self._fade
        for k, (window, length) in enumerate(zip(self._windows, WINDOWS)):
            full = window is not None and window.pieces >= length
            if full:
                counts[:, k] += window.squares(self._gain_doubt)
            if full or window is None:
                self._windows[k] = _Window(belief, self._size)
        self._counts = counts
        self._past.append(counts)

    def _know(self, counts):
        self._counts = counts
        self._past = deque([counts], maxlen=BEFORE // LOOK + 1)

    def _counts_before(self, pieces):
        return self._past[max(len(self._past) - 1 - -(-pieces // LOOK), 0)]

    def _renew(self):
        self.now = Trust(self._precision, _factor(self._counts))


def any_load(prior):
    """Return the covariance (10, 10) of the products of any load around nothing."""
    mass = prior.mean[0] + ANY_LOAD * prior.std[0]
    reach = np.linalg.norm(prior.mean[1:4]) + ANY_LOAD * prior.std[1:4].max()
    return np.diag(mass * reach ** np.array([0, 1, 1, 1, 2, 2, 2, 2, 2, 2])) ** 2


class _Window:
    """
    Pieces since a belief: mean (10 + r,) of products and nuisances, its covariance, and what
    torque constants move it by (10 + r, n).
    """

    def __init__(self, belief, size):
        self._mean, self._covariance, self._moved = belief
        self.information, self.pieces = Information(*size), 0

    def squares(self, gain_doubt):
        """Return b^T S^-1 b, the rank of S, and 1 for the window."""
        rows = self.information.matrix[:10]
        b = self.information.vector[:10] - rows @ self._mean
        covariance = rows[:, :10] + rows @ self._covariance @ rows.T
        # Misread torque constants move the window's torques and what was foretold of them.
        misread = (self.information.by_joint[:, :10] @ self._mean[:10]).T - rows @ self._moved
        covariance = covariance + gain_doubt ** 2 * misread @ misread.T
        return *normalised_square(b, covariance), 1.0


def _factor(counts):
    """
    Return the factor on variances of counts (3, lengths): squares, ranks, windows; at least 1.

    What so few windows tell is a Student's variance: its 95 % are wider than a normal's.
    """
    student = 1.0 + STUDENT / (1.0 + counts[2])
    return max(1.0, float((1.0 + (_shares(counts) - 1.0) * student ** 2).max()))


def _shares(counts):
    """Return (lengths,): what innovations were of what is stated, 1 where nothing was compared."""
    squares, ranks, _ = counts
    return (ASSUMED + squares) / (ASSUMED + ranks)
