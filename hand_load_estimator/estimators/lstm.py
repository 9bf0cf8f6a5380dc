"""
Method `lstm`: a trained LSTM corrects every sample of the regression (E1.3, E6.1).

The network sees motion, torque difference and temperature of each joint (E3.1), the regressor's
domain through the running Bayesian posterior (E4.1), and gives the mean and the variance of the
ten parameters: through its corrections, and by shift and spread of the outcome.
A network that was trained beside temperatures is not asked without them: the regression by itself
(bayes.py) is as near, and its intervals hold.
"""

import numpy as np

from ..learning.artefact import trained_beside_temperatures
from ..learning.features import REFRESH, SlowResidual, features
from ..learning.interval_factors import factors_at, level_of
from ..load import message_from_shape
from ..torque.presliding import doubt_after
from .contact_watch import ContactWatch
from .information import message_covariance
from .innovation_scale import InnovationScale
from .load_prior import load_prior
from .lstm_cell import LstmCell
from .method import Belief, check_origin, fitting, joined_state, part_of
from .mismatch import MismatchWatch
from .regression import LoadRegression, moves, MOVING
from .watching import Watching
from .weighting import innovation_of, joined_columns

# Doubt about the friction of an arm that has stood longer [s] than the rests of training: what the
# network has not seen it is not asked about, and time stands still for it.
RESTED = doubt_after(1.0)


class Lstm(Watching):
    """Estimate the load with an Artefact; the model may be any of the arm it was trained for."""

    name = 'lstm'

    def __init__(self, model, uncertainties, artefact):
        self._model, self._robot = model, model.robot
        self._prior = load_prior(self._robot)
        # The doubt about torque constants is drawn in training, so the spread holds it already.
        size = self._prior, self._robot.n, uncertainties, self._robot.effort.torque_constants_std
        self._watcher = self._plain = LoadRegression(
            *size, doubt_elsewhere=True, load_share=model.residuals.load_share)
        self._learned = LoadRegression(*size, doubt_elsewhere=True, trust=self._plain.trust)
        self._beside_temperatures = trained_beside_temperatures(artefact.card)
        self._asked = not self._beside_temperatures
        self._contacts = ContactWatch(model, self._plain, uncertainties)
        self._cell = LstmCell(artefact.weights, self._robot.n)
        self._calibration = artefact.calibration
        self._level = model.friction_level()
        self._prior_std = np.sqrt(np.diag(self._plain.posterior.covariance))
        self._watch = MismatchWatch(self._robot.joints, model.residuals.rmse)
        self._scale = InnovationScale(model.residuals.rmse)
        self._shift, self._spread = np.zeros(10), np.zeros(10)
        self._restart()

    @property
    def trust(self):
        """The ModelTrust that its estimates count with."""
        return self._plain.trust

    @property
    def trusted(self):
        """The Trust in the torque model, as what is published counts with it now."""
        return self._scale.widened(self.trust.now)

    @property
    def tared(self):
        """Products (10,) declared zero by tare: those that its estimates are beside."""
        return self._learned.tared

    @property
    def mismatch(self):
        """Why the model does not explain the residual, or an empty string."""
        return self._contacts.reason or self._watch.reason or self.trust.misfit

    @property
    def asked(self):
        """Whether the network is asked, which knows motions of which all was measured."""
        return self._asked

    @property
    def reliability(self):
        """What ~/status tells of the network."""
        return {'network': 'asked' if self._asked else 'not asked: it was trained beside '
                'temperatures, and not of all joints one is known; method bayes meanwhile'}

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        self.settle()
        columns = joined_columns(prediction)
        if (self._contacts.look_for_push(sample, columns, prediction)
                and self._take_back(sample.stamp, surely=True)):
            self._contacts.hold()
        load = innovation_of(prediction, columns, self._known, self._plain.posterior)
        contact, another = self._contacts.update(sample, prediction, *load)
        if contact:
            again = self._contacts.old_load_again(sample, columns, prediction)
            if self._contacts.contact and not self._take_back(sample.stamp, again=again):
                self._leave_out_onset(sample, prediction)
            return self.belief()
        if another:
            self._plain.begin_anew(sample.stamp)
            self._after_change()
            load = innovation_of(prediction, columns, self._known, self._plain.posterior)
        self._watch.update(load[0], load[1] + prediction.stuck, sample.dt)
        self._scale.update(load[0], load[1] + prediction.stuck + prediction.noise, sample)
        features_now = self._features(sample, prediction, load)
        self._listen(sample)
        if self._asked and prediction.doubt.min() < RESTED:
            self._correction, shift, spread = self._cell.step(features_now)
            # An arm that stands tells nothing of the load: nor is it any better or worse known.
            # Answers of training are held as long (learning/objective.py).
            if np.abs(sample.v).max() > MOVING:
                self._shift, self._spread = shift, spread
        weights = sample.dt / prediction.counted
        # The plain regression only serves the next innovation, and to see a change.
        moving = moves(sample, prediction)
        self._plain.add(sample, columns, prediction.difference, weights, moving)
        self._learned.add(sample, columns, prediction.difference - self._correction * self._level,
                          weights, moving)
        self._settled = False
        if self._plain.look_at(sample.stamp):
            self._after_change()
        else:
            self._learned.update_posterior()
        return self.belief()

    def _listen(self, sample):
        """Note whether the network knows motions of which as much was measured as of this one."""
        known = not self._beside_temperatures or bool(np.isfinite(sample.temperature).all())
        if self._asked and not known:
            # What it said was of another time when it is asked again.
            self._cell.restart()
            self._correction = np.zeros(self._robot.n)
            self._shift, self._spread = np.zeros(10), np.zeros(10)
        self._asked = known

    def settle(self):
        """Bring the plain regression behind the innovations up to date, look for a change."""
        if self._settled:
            return
        self._settled = True
        self._count += 1
        if self._count % REFRESH == 0:
            self._renew()
        else:
            # At a renewal there is enough to do.
            changes = self._plain.changes
            self._plain.look_for_change()
            if self._plain.changes > changes:
                self._after_change()

    def _after_change(self):
        """Follow the plain regression, which has begun anew."""
        self._learned.begin_anew(self._plain.last_change, self._plain.changed_pieces,
                                 self._plain.expected)
        self._restart()
        self._contacts.changed()

    def _leave_out_onset(self, sample, prediction):
        if self._contacts.began and moves(sample, prediction):
            self._plain.drop_newest(sample.stamp)
            self._learned.drop_newest(sample.stamp)
            self._renew()

    def _take_back(self, stamp, **why):
        """Return to the load before a change that was a contact, if so; tell whether."""
        taken = self._plain.take_back(stamp, **why)
        if taken:
            self._learned.take_back(stamp, **why)
            self._cell.restart()
            self._shift, self._spread = self._said_before
            self._renew()
        return taken

    def belief(self):
        """Return the present Belief."""
        if not self._asked:
            alone = self._learned.widened(doubt_elsewhere=False)
            return Belief(alone.mean, alone.covariance * self._scale.beyond(self.factor))
        posterior, stated = self._learned.widened(), self._learned.posterior
        # The network was trained on models that are as they state: its unit is what they state.
        std = np.sqrt(stated.shape_covariance.diagonal())
        shape = posterior.shape + self._shift * std
        wide = np.exp(self._spread)
        covariance = message_covariance(
            shape, posterior.shape_covariance * wide * wide[:, None])
        factors = factors_at(self._calibration, level_of(wide * std, self._prior.std))
        wider = factors * np.sqrt(self._scale.beyond(self.factor))
        return Belief(message_from_shape(shape), covariance * wider * wider[:, None])

    def forget(self):
        """Forget the load."""
        self._plain.forget()
        self._learned.forget()
        self._restart()

    def tare(self):
        """Make what is held now the new zero."""
        # What is declared zero was found with the trust that the plain regression ends.
        self._learned.tare()
        self._plain.tare()
        self._restart()

    def state(self):
        """Return the states of both regressions and of the network."""
        self.settle()
        out = joined_state(plain=self._plain.state(), learned=self._learned.state())
        asked = np.array(float(self._asked))
        return out | {'innovations': self._scale.sums.copy(), 'asked': asked,
                      'memory': np.stack(self._cell.memory), 'shift': self._shift,
                      'spread': self._spread, 'weights': self._cell.fingerprint}

    def restore(self, state):
        """Go on from a state() of the same artefact."""
        check_origin(state, 'weights', self._cell.fingerprint, 'learned artefact')
        own = fitting(state, self.state())
        self._plain.restore(part_of(own, 'plain'))
        self._learned.restore(part_of(own, 'learned'))
        self._restart()
        self._cell.memory, self._shift, self._spread = own['memory'], own['shift'], own['spread']
        self._scale.sums, self._asked = own['innovations'], bool(own['asked'])

    def _restart(self):
        self._cell.restart()
        self._watch.clear()
        self._scale.clear()
        self._contacts.clear()
        self._slow = SlowResidual(self._robot.n)
        self._count, self._settled = 0, True
        self._correction = np.zeros(self._robot.n)
        # Of the load before, should a change turn out to have been a contact.
        self._said_before = self._shift, self._spread
        self._shift, self._spread = np.zeros(10), np.zeros(10)
        self._renew()

    def _renew(self):
        """Renew the plain posterior behind the innovations."""
        posterior = self._plain.update_posterior()
        self._known = self._plain.known()
        self._relative = np.sqrt(posterior.covariance.diagonal()) / self._prior_std

    def _features(self, sample, prediction, load):
        residuals, temperature = self._model.residuals, sample.temperature
        if not self._beside_temperatures:
            temperature = np.full(self._robot.n, np.nan)
        slow = self._slow.update(load[0], load[1], prediction.density, sample.dt)
        return features(self._robot.limits, (residuals.rmse, residuals.load_intensity),
                        (sample.q, sample.v, sample.a),
                        temperature - self._robot.reference_temperature,
                        (prediction.z, prediction.doubt, prediction.density),
                        prediction.difference, load, slow, self._relative)
