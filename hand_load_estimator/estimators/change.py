"""
Tell a changed load from noise: the evidence that recent data come from another load.

Recent information (L_r, v_r) is compared with what the older belief x ~ N(x_o, S_o) predicts:
z = v_r - L_r x_o has covariance L_r + L_r S_o L_r when nothing changed. A change d of the load
adds L_r d. With a prior N(0, P) on d the log Bayes factor of changed against unchanged is
b^T (A + P^-1)^-1 b / 2 - log det(I + P A) / 2, where A and b are the information about d in z.

What may have changed instead is one joint: its friction and offset, of which the model states how
far they drift. The same factor with P for these tells how well that explains the data.

A factor never exceeds half of the weighted square that the older belief leaves of the recent data,
which costs a sixth: the data of a healthy arm are hardly ever tested for another load.
"""

from collections import deque

import numpy as np

from ..load import products_jacobian_of_shape
from ..torque_model import DRIFTS
from .information import Information
from .positive_solve import positive_solve, unit

# Recent data are kept in pieces of about this length [s of motion] ...
PIECE = 0.06
# ... and tested over the last so many of them: the few always, the many in turns, as what shows
# in many only is no matter of a tenth of a second. BRIEF only where the model has foretold the
# torques well: a slip of the grasp is then seen 0.02 to 0.06 s sooner.
SHORT, BRIEF, MIDDLE, LONG = 2, 3, 5, 16
# Evidence is asked for so many times over in a moment: friction that a model lacks comes and goes
# in it. On sick development arms this brought as few false changes as not looking at all.
OF_A_MOMENT = 2.0
# Evidence needed: a log Bayes factor at which chance needs e^-25 of luck. Model error is not
# chance, hence so high.
EVIDENCE = 25.0
# Where the model has foretold the torques well, this share of it: two development arms, each ten
# minutes from cold, showed no evidence above 1. Four tenths see slips a little sooner still, and
# half as many false changes again on arms that ail; a moment for which no more is asked than for
# longer takes three more pushes of 24 for loads.
FORETOLD = 0.6
# Where the model has not foretold the torques another load has to be ahead of any one joint by as
# much evidence again, or by this share of what it would be: with few joints in motion that is
# less. On development arms with an undeclared effect that leaves 18 false changes of 23, all of
# the evidence 12, with picks missed while one joint moves.
OF_EXPECTED = 0.5
# How far a joint may have changed, in standard deviations of its stated drift: the likeliest of
# these counts, because how well a model knows its drift says nothing of what breaks.
ANY_JOINT = (30.0, 1e3, 3e4)
# [m] Standard deviation along each axis of how far a grasp slips: a change of three numbers is
# likely with less evidence than one of ten.
SLIP = 0.03
# A load below this [kg] leaves place and size free, but a change to a heavier one is likely.
LEAST_CHANGE_MASS = 1.0


def change_covariance(prior):
    """Return the covariance (10, 10) of what the products may change by when the load does."""
    shape = prior.mean.copy()
    shape[0] = max(shape[0], LEAST_CHANGE_MASS)
    jacobian = products_jacobian_of_shape(shape)
    return jacobian @ np.diag(prior.std ** 2) @ jacobian.T


def slip_covariance(shape):
    """Return the covariance (10, 10) of what the products of a shape (10,) change by in a slip."""
    moved = SLIP * products_jacobian_of_shape(shape)[:, 1:4]
    return moved @ moved.T


def log_bayes_factor(recent, older_mean, older_precision, change):
    """
    Return the log Bayes factor of a changed load.

    recent: Information; older_mean (d,), older_precision (d, d): belief without it; change
    (10, 10): covariance of what a load may change by.
    """
    left = recent.vector - recent.matrix @ older_mean
    return factor_of(*_told_of(slice(10), left, recent.matrix, older_precision), change)


def strongest_joint(recent, older_mean, older_precision, n):
    """
    Return the largest log Bayes factor of one joint that has changed, of n.

    Arguments as of log_bayes_factor; the last DRIFTS * n unknowns are the joints' drifts.
    """
    left = recent.vector - recent.matrix @ older_mean
    return _strongest_joint(left, recent.matrix, older_precision, n)


def expected_ahead(recent, older_mean, older_precision, change, n):
    """
    Return by how much [nats] another load would be ahead of any one joint, were it one.

    Arguments as of log_bayes_factor and strongest_joint. By next to nothing where only one joint
    moves: then neither the load nor the joint is told from the other.
    """
    left, load = recent.vector - recent.matrix @ older_mean, slice(10)
    b, a = _told_of(load, left, recent.matrix, older_precision)
    likeliest = change @ np.linalg.solve(unit(10) + a @ change, b)
    left = recent.matrix[:, load] @ likeliest
    return (factor_of(*_told_of(load, left, recent.matrix, older_precision), change)
            - _strongest_joint(left, recent.matrix, older_precision, n))


def _strongest_joint(left, matrix, older_precision, n):
    b, a = _told_of(slice(len(left) - DRIFTS * n, None), left, matrix, older_precision)
    drifts = [joint + n * np.arange(DRIFTS) for joint in range(n)]
    return max(factor_of(b[own], a[np.ix_(own, own)], spread ** 2 * unit(DRIFTS))
               for own in drifts for spread in ANY_JOINT)


def _told_of(where, left, matrix, older_precision):
    """
    Return b (k,), A (k, k): information about a change of the unknowns in a slice.

    left (d,): z = v_r - L_r x_o; matrix (d, d): L_r.
    """
    # (1 + L_r S_o)^-1 = S_o^-1 (S_o^-1 + L_r)^-1, where only positive matrices are solved with.
    solved = older_precision[where] @ positive_solve(
        older_precision + matrix, np.column_stack([left, matrix[:, where]]))
    return solved[:, 0], solved[:, 1:]


def factor_of(b, a, change):
    """Return the log Bayes factor of a change of covariance (k, k); b, a: as of _told_of."""
    inflated = unit(len(b)) + a @ change
    quadratic = b @ change @ np.linalg.solve(inflated, b)
    return 0.5 * (quadratic - np.linalg.slogdet(inflated)[1])


class RecentData:
    """
    The newest pieces of information, apart from the older sum, which fades.

    size: (joints, nuisances).
    """

    def __init__(self, n, nuisances, memory):
        self.size, self._memory = (n, nuisances), memory
        self.clear()

    def clear(self):
        """Forget everything."""
        self.older, self.pieces, self._lengths = Information(*self.size), deque(), deque()
        self._open, self._length = Information(*self.size), 0.0
        self._closed = Information(*self.size)

    def begin_with(self, older):
        """Forget everything, and take an Information for what older data have told."""
        self.clear()
        self.older.add(older)
        self._closed.add(older)

    def add(self, columns, difference, weights, moved):
        """Add a sample that stands for `moved` [s] of motion; tell whether it ended a piece."""
        self._open.add_rows(columns, difference, weights)
        self._length += moved
        # The nearest to the length: stamps jitter.
        if self._length < PIECE - 0.5 * moved:
            return False
        self.pieces.append(self._open)
        self._lengths.append(self._length)
        self._closed.add(self._open)
        self._open, self._length = Information(*self.size), 0.0
        if len(self.pieces) > LONG + 1:
            # A sum anew would cost ten times as much; rounding leaves 1e-12 here after hours.
            kept = np.exp(-self._lengths.popleft() / self._memory)
            self._closed.take_off(self.older, 1.0 - kept)
            self.older.scale(kept)
            self.older.add(self.pieces.popleft())
        return True

    def drop_newest(self, last):
        """Forget the open piece, and the last one where `last` says so."""
        self._open, self._length = Information(*self.size), 0.0
        if last and self.pieces:
            self._closed.take_off(self.pieces.pop(), 1.0)
            self._lengths.pop()

    def total(self):
        """Return the Information of everything kept."""
        return self._closed.plus(self._open)

    def closed(self):
        """Return the Information of everything but the open piece."""
        return self._closed

    def without_newest(self, count):
        """Return the Information of all but the open piece and the last `count` pieces."""
        return self._sum(self.older, list(self.pieces)[:-count])

    def split(self, count):
        """
        Return (older, recent) with the last `count` pieces as recent, or None.

        What is open is in neither.
        """
        if len(self.pieces) <= count:
            return None
        pieces = list(self.pieces)
        return (self._sum(self.older, pieces[:-count]),
                self._sum(Information(*self.size), pieces[-count:]))

    def with_open(self, recent):
        """Return the sum of an Information of recent pieces and the open one."""
        return recent.plus(self._open)

    def _sum(self, first, others):
        total = Information(*self.size)
        total.add(first)
        for other in others:
            total.add(other)
        return total
