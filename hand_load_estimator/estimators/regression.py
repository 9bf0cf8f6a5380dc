"""The recursive regression that `bayes` and `lstm` share: sums, posterior, load changes."""

import numpy as np

from ..torque.presliding import REST_SPEED
from ..torque.sliding import DOUBT, TURNED
from ..torque_model import DRIFTS
from .change import change_covariance, EVIDENCE, LONG, RecentData, slip_covariance
from .change_windows import ChangeWindows, Older
from .information import gain_covariance, Information, posterior_of, share_less_tare, Trust
from .load_prior import LoadPrior
from .method import Belief, checked
from .model_trust import ModelTrust
from .old_load import OldLoad, OldLoads

# Data older than this much motion [s] fade: friction drifts as joints warm.
MEMORY = 120.0
# Faster than this [rad/s] a joint tells something.
MOVING = 0.02
# For so long [s] after a change was seen the motion filter still shows the load before it: seen it
# is 0.03 s late at the earliest, and 0.08 s after it 1.4 % are left.
SETTLING = 0.05
# In the last so many seconds of motion before a contact is told it may have begun. They are left
# out, but no more than once in so many [s]: what chatters would leave nothing.
ONSET, ONCE_IN = 0.15, 2.0
# While an arm stands no piece ends. The last so many are left out where the old load comes back:
# it may have been let go already while the arm came to rest.
AT_REST = 5


def moves(sample, prediction):
    """
    Tell whether a joint moves, or creeps so that its friction has turned, slow as it may be.

    Its torques count as those of any motion then: a load change shows in them, too.
    """
    speed = np.abs(sample.v)
    return bool(((speed > MOVING) | (speed > REST_SPEED) & (prediction.doubt < DOUBT)
                 & (np.abs(prediction.z) > TURNED)).any())


class LoadRegression:
    """
    Hold the information about the load, give posteriors, notice load changes.

    prior: LoadPrior; n joints; nuisances: number of model columns; gain_doubt: relative
    standard deviation of the torque constants; doubt_elsewhere: leave it out of posteriors,
    because a network's spread holds it; load_share: as of Residuals, which the model's variances
    were scaled by; trust: the ModelTrust of a LoadRegression that looks for load changes and for
    what the model does not foretell; without one it does so itself.
    changes counts load changes; last_change is the stamp of the newest, or None; changed_pieces:
    how many pieces of recent data it reaches back; older_belief: the Older before it, of one that
    looks itself. change (10, 10): covariance of what the products may change by when the load
    does. The last DRIFTS * n nuisances are the joints' (torque_model.nuisance_columns).
    """

    def __init__(self, prior, n, nuisances, gain_doubt=0.0, doubt_elsewhere=False,
                 load_share=1.0, trust=None):
        self._prior = self._first_prior = prior
        self._gain_doubt, self._watch = gain_doubt, trust is None
        self._counted_doubt = 0.0 if doubt_elsewhere else gain_doubt
        # Only the doubt about torque constants asks for each joint's part.
        size = n if gain_doubt > 0.0 else 0, nuisances
        self.trust = trust or ModelTrust(prior, nuisances, size[0], gain_doubt)
        self._joints = n
        # Variances scaled down make evidence of model error; so the threshold goes up with them.
        self._evidence = EVIDENCE / min(load_share, 1.0)
        self._recent = RecentData(*size, MEMORY)
        self._start, self._tare, self._zero = prior.mean, None, np.zeros(10)
        self.changes, self.last_change, self.changed_pieces = 0, None, AT_REST
        self.older_belief, self._old = None, OldLoads()
        self._ended, self._dropped = -np.inf, -np.inf
        self.change = change_covariance(prior)
        self._change_precision = np.linalg.inv(self.change)
        self._windows = ChangeWindows(self.change, self._recent, n)
        self._unchecked = None
        self.posterior = self._solve()

    def add(self, sample, columns, difference, weights, moving):
        """
        Add a sample: columns (n, 10 + r), difference (n,), weights (n,); moving: as of `moves`.

        Nothing is added while the motion filter still shows the load before a change.
        """
        if self.last_change is not None and 0.0 <= sample.stamp - self.last_change < SETTLING:
            return
        difference = self.beside_tared(columns, difference)
        if not self._recent.add(columns, difference, weights, sample.dt if moving else 0.0):
            return
        self._ended = sample.stamp
        if self._watch:
            self._unchecked = sample.stamp
            self.trust.take(self._recent.pieces[-1])
            self._windows.take(self._recent.pieces[-1])

    def beside_tared(self, columns, difference):
        """Return a difference (n,) without the torque of what was declared zero."""
        if self._tare is None:
            return difference
        return difference - columns[:, :10] @ self._zero

    def look_at(self, stamp):
        """
        Tell whether the newest sample, of a stamp [s], shows another load; if so, forget the load.

        At once, where the model has foretold the torques well; elsewhere look_for_change does.
        """
        if not self._windows.changed_by_sample():
            return False
        self.begin_anew(stamp, self._pieces_since_change())
        return True

    def look_for_change(self):
        """
        Test the newest pieces against older ones; forget the load if it changed.

        If it did not, they tell how far the model is to be trusted.
        """
        if self._unchecked is None:
            return
        stamp, self._unchecked = self._unchecked, None
        # Torques that vary so much more than stated make so much more evidence by themselves.
        self._windows.begin(self.evidence_needed(), self._older_belief,
                            self.trust.foretold_before())
        if self._windows.changed_by_pieces():
            # Nobody knows since when: a change is seen while the window still holds old data.
            self.begin_anew(stamp, self._pieces_since_change())
        else:
            self.trust.look(self._recent.closed())

    def evidence_needed(self):
        """Return the evidence [nats] asked of a change where the model does not foretell."""
        return self._evidence * self.trust.factor_before()

    def present_belief(self):
        """Return the Older that all data so far are."""
        return self._older_belief(self._recent.total())

    def update_posterior(self):
        """
        Solve for the Posterior of all data so far and return it.

        Variances of torques are those stated: what is expected next is judged by it.
        """
        self.posterior = self._solve()
        self._start = self.posterior.shape
        return self.posterior

    def load_information(self):
        """Return matrix (10, 10), vector (10,): what all data so far say about the products."""
        self._total = self._recent.total()
        return share_less_tare(self._total, self._tare, self.trust.now)

    def gain_covariance(self, shape, covariance):
        """Return what doubtful torque constants add to a belief (10,), (10, 10) in shape order."""
        return gain_covariance(self._total, shape, covariance, self._gain_doubt,
                               self.trust.now)

    def known(self):
        """
        Return (10 + r,): products and nuisances as the present posterior has them.

        The products include what tare declared zero, because the torque does.
        """
        products = self.posterior.products
        nuisance = self._total.nuisance_given(products, self.trust.now)
        return np.concatenate([products + self._zero, nuisance])

    def forget(self):
        """Forget the load, and what was found of the model's agreement."""
        if self._watch:
            self.trust.clear()
        self._forget_data(self._first_prior)

    def _forget_data(self, prior):
        self._old.forget()
        self._recent.clear()
        self._forget_windows()
        self._prior, self._start = prior, prior.mean
        self.posterior = self._solve()

    @property
    def expected(self):
        """LoadPrior of what is held, before the data of it."""
        return self._prior

    @property
    def tared(self):
        """Products (10,) declared zero by tare."""
        return self._zero.copy()

    def tare(self):
        """Declare the load held now zero; its uncertainty stays in every later estimate."""
        self.update_posterior()
        # As it is published: later data say nothing of how wrong the torques of these were.
        held = self.widened(doubt_elsewhere=False)
        self._zero = self._zero + held.products
        self._tare = held.products_covariance
        if self._watch:
            self.trust.restart(self._tare)
        self._forget_data(self._first_prior)

    def state(self):
        """Return {name: array}: what restore() goes on from."""
        total = self._recent.total()
        return {'matrix': total.matrix, 'vector': total.vector, 'by_joint': total.by_joint,
                'start': self._start, 'zero': self._zero, 'prior_mean': self._prior.mean,
                'prior_std': self._prior.std,
                'tare': np.zeros((10, 10)) if self._tare is None else self._tare,
                **{f'trust_{name}': value for name, value in self.trust.state().items()}}

    def restore(self, state):
        """
        Go on from a state() of another run; ValueError when it does not fit.

        What drifts between runs (offset and friction of each joint) is found anew. All data are
        older ones now, which recent ones are tested against: a load exchanged since is noticed.
        """
        n, size = self._recent.size
        shapes = {'matrix': (10 + size, 10 + size), 'vector': (10 + size,),
                  'by_joint': (n, 10 + size, 10), 'start': (10,), 'zero': (10,), 'tare': (10, 10),
                  'prior_mean': (10,), 'prior_std': (10,)}
        shapes |= {f'trust_{name}': np.shape(value)
                   for name, value in self.trust.state().items()}
        state = checked(state, shapes)
        total = Information(n, size)
        total.matrix[:], total.vector[:] = state['matrix'], state['vector']
        total.by_joint[:] = state['by_joint']
        drifts, precision = DRIFTS * self._joints, state['trust_precision']
        self._recent.begin_with(total.without_last(drifts, Trust(np.diag(precision))))
        # What was held before a change of this run is none of that one's loads.
        self._old.forget()
        self._forget_windows()
        self._start, self._zero = state['start'], state['zero']
        self._prior = LoadPrior(state['prior_mean'], state['prior_std'])
        self._tare = state['tare'] if state['tare'].any() else None
        if self._watch:
            kept = np.arange(size) < size - drifts
            self.trust.resume(state['trust_counts'], np.where(kept, precision, 1.0),
                              state['tare'])
        self.update_posterior()

    def belief(self):
        """Return the Belief as far as the model is trusted now."""
        posterior = self.widened()
        return Belief(posterior.mean, posterior.covariance)

    def widened(self, doubt_elsewhere=True):
        """
        Return the last posterior, with the variances of torques as they turn out to be.

        doubt_elsewhere: as of the regression; False counts the doubt in all the same.
        """
        doubt = self._counted_doubt if doubt_elsewhere else self._gain_doubt
        if self.trust.now.factor <= 1.0 and doubt == self._counted_doubt:
            return self.posterior
        return posterior_of(self._total, self._prior, self.posterior.shape, doubt, self._tare,
                            self.trust.now)

    def load_as_stated(self):
        """
        Return the products (10,) that are believed, and their covariance (10, 10) as stated.

        That is how well they were known if the torque model were no more wrong than it states.
        """
        stated = posterior_of(self._total, self._prior, self.posterior.shape, self._gain_doubt,
                              self._tare)
        return self.widened().products, stated.products_covariance

    def _solve(self):
        self._total = self._recent.total()
        return posterior_of(self._total, self._prior, self._start, self._counted_doubt,
                            self._tare, Trust(self.trust.now.precision))

    def begin_anew(self, stamp, pieces=AT_REST, expected=None):
        """
        Forget the data of the load because another is held since about `stamp` [s].

        pieces: how many of the newest are no data of the old load, should it come back. expected:
        LoadPrior of the other load, None for any; where this looks itself it tells by the old one.
        """
        older, trust = self._recent.without_newest(pieces), self.trust.state_before(pieces)
        old = OldLoad(older, self._start, self._prior, trust)
        if self._watch:
            self.older_belief = self._older_belief(older)
            expected = self._first_prior.after(self.older_belief.load.shape)
            self.trust.begin_anew(pieces)
        self._forget_data(expected or self._first_prior)
        self._old.keep(stamp, old)
        self.changes += 1
        self.last_change, self.changed_pieces = stamp, pieces

    def take_back(self, stamp, surely=False, again=False):
        """
        Return to the load before the newest change, if that was just now; tell whether.

        What looked like another load has turned out to be a contact, surely so or not; again: the
        old load explains the torques again.
        """
        # A model that has not foretold torques as it states ails.
        old = self._old.again(stamp) if again else self._old.back(
            stamp, surely, surely and not self.trust.as_stated_before())
        if old is None:
            return False
        self._start, self._prior = old.start, old.expected
        self._recent.begin_with(old.data)
        if self._watch:
            self.trust.resume(**old.trust)
        self._forget_windows()
        self.changes += 1
        self.last_change = stamp
        self.update_posterior()
        return True

    def drop_newest(self, stamp):
        """Forget the last moments of motion before a stamp [s]: a contact has begun in them."""
        # An earlier stamp is of a clock that was set back.
        if 0.0 <= stamp - self._dropped < ONCE_IN:
            return
        self._dropped = stamp
        self._recent.drop_newest(last=0.0 <= stamp - self._ended < ONSET)
        if self._watch:
            self.trust.drop_windows()
        self._forget_windows()
        self.update_posterior()

    def _forget_windows(self):
        self._windows.clear()
        self._unchecked = None

    def _pieces_since_change(self):
        """Return how many pieces are most likely another load's, and the one it came in."""
        evidence = {}
        for count in range(1, LONG + 1):
            split = self._recent.split(count)
            if split is not None:
                evidence[count] = self._windows.evidence(
                    self._recent.with_open(split[1]), self._older_belief(split[0]))
        return 1 + max(evidence, key=evidence.get)

    def _older_belief(self, older):
        """Return the Older of an Information."""
        trust = Trust(self.trust.now.precision)
        posterior = posterior_of(older, self._prior, self._start, trust=trust)
        precision = older.matrix.copy()
        precision[:10, :10] += self._change_precision
        precision[10:, 10:] += trust.precision
        mean = np.concatenate([posterior.products,
                               older.nuisance_given(posterior.products, trust)])
        return Older(mean, precision, slip_covariance(posterior.shape), posterior)
