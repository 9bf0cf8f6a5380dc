"""What the methods that look for the load among candidates share: dtau, sums, load changes."""

import numpy as np

from ..load import message_from_shape
from .bayes import Bayes
from .information import message_covariance
from .load_prior import load_prior
from .mass_place import MassPlacePosterior
from .method import Belief, check_origin, fitting, joined_state, part_of
from .regression import LoadRegression
from .watching import Watching
from .weighting import joined_columns


class BesideBayes(Watching):
    """
    A Method with its own belief over its own sums, beside a Bayes that watches for changes.

    Subclasses: _restart() forgets candidates; _take(sample, prediction, columns) looks at one
    sample, whose prediction holds the offset torque, and counts it or not; _answer() returns
    shape (10,) and its covariance (10, 10); _found() returns {name: array}, all that the answer
    is made from beside the sums, and _resume(found) takes it over behind them.
    """

    def __init__(self, model, uncertainties, function):
        robot = model.robot
        self._function, self._prior = function, load_prior(robot)
        self._watcher = self._plain = Bayes(model, uncertainties)
        self._counted = LoadRegression(self._prior, robot.n, uncertainties,
                                       robot.effort.torque_constants_std,
                                       trust=self._plain.trust)
        self._restart()

    @property
    def tared(self):
        """Products (10,) declared zero by tare."""
        return self._counted.tared

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        self.settle()
        changes = self.changes
        corrected = self._function.corrected(sample, prediction)
        self._plain.update(sample, corrected)
        if self.changes > changes:
            self._begin_anew()
        if not self._plain.refused:
            self._take(sample, corrected, joined_columns(corrected))
        return self.belief()

    def settle(self):
        """Look for a load change."""
        changes = self.changes
        self._plain.settle()
        if self.changes > changes:
            self._begin_anew()

    def belief(self):
        """Return the present Belief."""
        shape, covariance = self._answer()
        return Belief(message_from_shape(shape), message_covariance(shape, covariance))

    def forget(self):
        """Forget the load."""
        self._plain.forget()
        self._counted.forget()
        self._restart()

    def tare(self):
        """Make what is held now the new zero."""
        # What is declared zero was found with the trust that the plain regression ends.
        self._counted.tare()
        self._plain.tare()
        self._restart()

    def state(self):
        """Return the states of both regressions and of the answer, and whose function it is."""
        return {**joined_state(plain=self._plain.state(), counted=self._counted.state(),
                               found=self._found()),
                'function': self._function.fingerprint}

    def restore(self, state):
        """Go on from a state() of the same learned function."""
        check_origin(state, 'function', self._function.fingerprint, 'learned torque difference')
        own = fitting(state, self.state())
        # The plain regression brings the trust that the other one counts with.
        self._plain.restore(part_of(own, 'plain'))
        self._counted.restore(part_of(own, 'counted'))
        self._resume(part_of(own, 'found'))

    def _begin_anew(self):
        self._counted.begin_anew(self.last_change)
        self._restart()

    def _posterior(self, mass):
        """Return the MassPlacePosterior of what was counted, for about that mass [kg]."""
        return MassPlacePosterior(*self._counted.load_information(), self._prior, mass)

    def _joined(self, place, place_covariance, inertia, inertia_covariance, slope):
        """
        Return shape (10,), covariance (10, 10) with the doubt about torque constants.

        place (4,): mass and centre of mass; inertia (6,) given them, slope (6, 4) with them.
        """
        shape, covariance = np.concatenate([place, inertia]), np.empty((10, 10))
        covariance[:4, :4] = place_covariance
        covariance[4:, :4] = slope @ place_covariance
        covariance[:4, 4:] = covariance[4:, :4].T
        covariance[4:, 4:] = inertia_covariance + covariance[4:, :4] @ slope.T
        return shape, covariance + self._counted.gain_covariance(shape, covariance)
