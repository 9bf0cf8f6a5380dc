"""The recursive regression that `bayes` and `lstm` share: sums, posterior, load changes."""

import numpy as np

from ..load import products_jacobian_of_shape
from .change import EVIDENCE, WINDOWS, RecentData, log_bayes_factor
from .information import gain_covariance, posterior_of, share_less_tare
from .method import Belief

# Data older than this much motion [s] fade: friction drifts as joints warm.
MEMORY = 120.0
# Faster than this [rad/s] a joint tells something.
MOVING = 0.02
# A load below this [kg] leaves place and size free, but a change to a heavier one is likely.
LEAST_CHANGE_MASS = 1.0


class LoadRegression:
    """
    Hold the information about the load, give posteriors, notice load changes.

    prior: LoadPrior; n joints; nuisances: number of model columns; gain_doubt: relative
    standard deviation of the torque constants; watch: look for load changes in motion.
    changes counts load changes; last_change is the
    stamp of the newest, or None.
    """

    def __init__(self, prior, n, nuisances, gain_doubt=0.0, watch=True):
        self._prior, self._gain_doubt, self._watch = prior, gain_doubt, watch
        self._recent = RecentData(n, nuisances, MEMORY)
        self._start, self._tare, self._zero = prior.mean, None, np.zeros(10)
        self.changes, self.last_change = 0, None
        self._turn, self._unchecked = 0, None
        self.posterior = self._solve()

    def add(self, sample, columns, difference, weights):
        """Add a sample: columns (n, 10 + r), difference (n,), weights (n,)."""
        moved = sample.dt if (np.abs(sample.v) > MOVING).any() else 0.0
        difference = difference - columns[:, :10] @ self._zero
        if self._recent.add(columns, difference, weights, moved) and self._watch:
            self._unchecked = sample.stamp

    def look_for_change(self):
        """Test the newest data against older ones; forget the load if it changed."""
        if self._unchecked is None:
            return
        stamp, self._unchecked = self._unchecked, None
        # The windows take turns, which halves the longest time a sample takes.
        self._turn = (self._turn + 1) % len(WINDOWS)
        split = self._recent.split(WINDOWS[self._turn])
        if split is None:
            return
        older, recent = split
        mean, covariance = self._older_belief(older)
        if log_bayes_factor(recent, mean, covariance, self._change_covariance()) > EVIDENCE:
            # Nobody knows since when: a change is seen while the window still holds old data.
            self.begin_anew(stamp)

    def update_posterior(self):
        """Solve for the Posterior of all data so far and return it."""
        self.posterior = self._solve()
        self._start = self.posterior.shape
        return self.posterior

    def load_information(self):
        """Return matrix (10, 10), vector (10,): what all data so far say about the products."""
        self._total = self._recent.total()
        return share_less_tare(self._total, self._tare)

    def gain_covariance(self, shape, covariance):
        """Return what doubtful torque constants add to a belief (10,), (10, 10) in shape order."""
        return gain_covariance(self._total, shape, covariance, self._gain_doubt)

    def known(self):
        """
        Return (10 + r,): products and nuisances as the present posterior has them.

        The products include what tare declared zero, because the torque does.
        """
        products = self.posterior.products
        return np.concatenate([products + self._zero, self._total.nuisance_given(products)])

    def forget(self):
        """Forget the load."""
        self._recent.clear()
        self._unchecked = None
        self._start = self._prior.mean
        self.posterior = self._solve()

    @property
    def tared(self):
        """Products (10,) declared zero by tare."""
        return self._zero.copy()

    def tare(self):
        """Declare the load held now zero; its uncertainty stays in every later estimate."""
        self.update_posterior()
        self._zero = self._zero + self.posterior.products
        self._tare = self.posterior.products_covariance
        self.forget()

    def belief(self):
        """Return the Belief of the last posterior."""
        return Belief(self.posterior.mean, self.posterior.covariance)

    def _solve(self):
        self._total = self._recent.total()
        return posterior_of(self._total, self._prior, self._start, self._gain_doubt,
                            self._tare)

    def begin_anew(self, stamp):
        """Forget the load because another is held since about `stamp` [s]."""
        self.forget()
        self.changes += 1
        self.last_change = stamp

    def _older_belief(self, older):
        """Return the belief (d,), (d, d) about load and nuisances from older data."""
        posterior = posterior_of(older, self._prior, self._start)
        precision = older.matrix.copy()
        precision[:10, :10] += np.linalg.inv(self._change_covariance())
        precision[range(10, len(precision)), range(10, len(precision))] += 1.0
        mean = np.concatenate([posterior.products, older.nuisance_given(posterior.products)])
        return mean, np.linalg.inv(precision)

    def _change_covariance(self):
        """Return (10, 10): what the products may change by when the load does."""
        shape = self._prior.mean.copy()
        shape[0] = max(shape[0], LEAST_CHANGE_MASS)
        jacobian = products_jacobian_of_shape(shape)
        return jacobian @ np.diag(self._prior.std ** 2) @ jacobian.T
