"""Method `bayes`: recursive Bayesian regression with physics for weights (E7.3, eq. 13-14)."""

import numpy as np

from .contact_watch import ContactWatch
from .innovation_scale import InnovationScale
from .load_prior import load_prior
from .method import Belief, checked
from .mismatch import MismatchWatch
from .regression import LoadRegression, moves
from .watching import Watching
from .weighting import innovation_of, joined_columns


class Bayes(Watching):
    """
    Estimate the load without any learned part; works for every robot with a torque model.

    innovation, spread (n,): what the last sample said that was not expected [Nm], and its
    variance by the belief about the load before it [Nm^2]. refused: whether it was left out, as a
    contact's.
    """

    name = 'bayes'

    def __init__(self, model, uncertainties):
        robot = model.robot
        self._watcher = self._regression = LoadRegression(
            load_prior(robot), robot.n, uncertainties, robot.effort.torque_constants_std,
            load_share=model.residuals.load_share)
        self._contacts = ContactWatch(model, self._regression, uncertainties)
        self._watch = MismatchWatch(robot.joints, model.residuals.rmse)
        self._scale = InnovationScale(model.residuals.rmse)
        self._known = self._regression.known()
        self.innovation, self.spread = np.zeros((2, robot.n))
        self.refused = False

    @property
    def mismatch(self):
        """Why the model does not explain the residual, or an empty string."""
        return self._contacts.reason or self._watch.reason or self.trust.misfit

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        self.settle()
        columns = joined_columns(prediction)
        if (self._contacts.look_for_push(sample, columns, prediction)
                and self._take_back(sample.stamp, surely=True)):
            self._contacts.hold()
        innovation, spread, torque = self._unexpected(prediction, columns)
        self.refused, another = self._contacts.update(sample, prediction, innovation, spread,
                                                      torque)
        if self.refused:
            again = self._contacts.old_load_again(sample, columns, prediction)
            if self._contacts.contact and not self._take_back(sample.stamp, again=again):
                self._leave_out_onset(sample, prediction)
            return self.belief()
        if another:
            self._regression.begin_anew(sample.stamp)
            innovation, spread = self._after_change(prediction, columns)
        self._watch.update(innovation, spread + prediction.stuck, sample.dt)
        self._scale.update(innovation, spread + prediction.stuck + prediction.noise, sample)
        self._regression.add(sample, columns, prediction.difference,
                             sample.dt / prediction.counted, moves(sample, prediction))
        if self._regression.look_at(sample.stamp):
            self._after_change(prediction, columns)
        else:
            self._regression.update_posterior()
        return self.belief()

    def _leave_out_onset(self, sample, prediction):
        if self._contacts.began and moves(sample, prediction):
            self._regression.drop_newest(sample.stamp)
            self._known = self._regression.known()

    def _take_back(self, stamp, **why):
        taken = self._regression.take_back(stamp, **why)
        if taken:
            self._known = self._regression.known()
        return taken

    def _after_change(self, prediction, columns):
        """Begin the watches anew; return innovation and its variance (n,) by the new belief."""
        self._clear_watches()
        self._contacts.changed()
        self._known = self._regression.known()
        return self._unexpected(prediction, columns)[:2]

    def _unexpected(self, prediction, columns):
        """Return innovation, its variance by the belief and the load's torque, as noted."""
        found = innovation_of(prediction, columns, self._known, self._regression.posterior)
        self.innovation, self.spread = found[:2]
        return found

    def settle(self):
        """Look for a load change and renew what the next innovation is counted from."""
        changes = self.changes
        self._regression.look_for_change()
        if self.changes > changes:
            self._clear_watches()
            self._contacts.changed()
        self._known = self._regression.known()

    @property
    def nuisances(self):
        """The model's uncertain directions (r,), as the present belief has them."""
        return self._known[10:]

    @property
    def trust(self):
        """The ModelTrust that its estimates count with."""
        return self._regression.trust

    @property
    def trusted(self):
        """The Trust in the torque model, as what is published counts with it now."""
        return self._scale.widened(self.trust.now)

    def belief(self):
        """Return the present Belief."""
        belief = self._regression.belief()
        return Belief(belief.mean, belief.covariance * self._scale.beyond(self.factor))

    def forget(self):
        """Forget the load."""
        self._regression.forget()
        self._clear_watches()
        self._known = self._regression.known()

    def tare(self):
        """Make what is held now the new zero."""
        self._regression.tare()
        self._clear_watches()
        self._known = self._regression.known()

    def _clear_watches(self):
        self._watch.clear()
        self._scale.clear()
        self._contacts.clear()

    def state(self):
        """Return the state of the regression, and how innovations were."""
        return {**self._regression.state(), 'innovations': self._scale.sums.copy()}

    def restore(self, state):
        """Go on from a state()."""
        scale = checked(state, {'innovations': self._scale.sums.shape})
        self._regression.restore(state)
        self._clear_watches()
        self._scale.sums = scale['innovations']
        self._known = self._regression.known()
