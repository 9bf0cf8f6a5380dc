"""
Method `least_squares`: eq. 12 solved by weighted linear regression (E7.2).

    u = P (sum K^T W dtau + S0^-1 u0),  P = (sum K^T W K + S0^-1)^-1

over the joints that move; W is one over the mean square of a joint's residual. u0, S0 are the load
prior as products: an answer is asked for before torques tell all ten. Nothing of what the model
states of its own errors helps the estimate, and nothing fades.

W takes errors of samples for independent and the model for exact, so P is not how well u is known.
What the model states of its errors e gives that, with f of model_trust.py:

    S = P (S0^-1 + f C + E) P,  C = covariance of sum K^T W e

e is noise of a stated density, friction whose state is not known, which lasts (presliding.py), and
the model's uncertain directions; E is of torque constants and tare. Where torques tell nothing S
is the prior's. Where they have just begun to, it may be wider: W trusts them too early.
"""

import math

import numpy as np

from ..load import message_from_products, products_jacobian_of_message
from ..torque.presliding import STUCK_TIME
from .information import Information
from .load_prior import load_prior
from .method import Belief, fitting, joined_state, part_of
from .positive_solve import positive_solve, unit
from .regression import MOVING, SETTLING
from .watched_by_bayes import WatchedByBayes
from .weighting import joined_columns


class LeastSquares(WatchedByBayes):
    """
    Estimate the load by least squares on the torque model.

    `bayes` beside it tells what a regression cannot.
    """

    name = 'least_squares'

    def __init__(self, model, uncertainties):
        super().__init__(model, uncertainties)
        robot = model.robot
        self._residuals, self._weights = model.residuals, 1.0 / model.residuals.rmse ** 2
        self._gain_doubt = robot.effort.torque_constants_std
        self._size = robot.n if self._gain_doubt > 0.0 else 0, uncertainties
        prior, covariance = load_prior(robot).products
        self._precision = np.linalg.inv(covariance)
        self._from_prior = self._precision @ prior
        self._zero, self._zero_doubt = np.zeros(10), np.zeros((10, 10))
        self._restart()

    @property
    def tared(self):
        """Products (10,) declared zero by tare."""
        return self._zero.copy()

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        if self._counts(sample, prediction) and not self._shows_another_load(sample.stamp):
            self._take(sample, prediction)
            self._solve()
        return self._belief

    def tare(self):
        """Declare the load held now zero; its uncertainty stays in every later estimate."""
        self._zero, self._zero_doubt = self._zero + self._products, self._covariance
        self._beside.tare()
        self._restart()

    def state(self):
        """Return the state of `bayes` beside, the sums, and what is tared."""
        sums = self._sums
        return {**joined_state(beside=self._beside.state()), 'sums_matrix': sums.matrix.copy(),
                'sums_vector': sums.vector.copy(), 'sums_by_joint': sums.by_joint.copy(),
                'errors': self._errors.copy(), 'zero': self._zero, 'zero_doubt': self._zero_doubt}

    def restore(self, state):
        """Go on from a state(); friction lasts no longer than the gap."""
        own = fitting(state, self.state())
        self._beside.restore(part_of(own, 'beside'))
        sums = Information(*self._size)
        sums.matrix[:], sums.vector[:] = own['sums_matrix'], own['sums_vector']
        sums.by_joint[:] = own['sums_by_joint']
        self._zero, self._zero_doubt = own['zero'], own['zero_doubt']
        self._go_on(sums, own['errors'])

    def _restart(self):
        self._go_on(Information(*self._size), np.zeros((10, 10)))

    def _go_on(self, sums, errors):
        self._sums, self._errors = sums, errors
        # What unknown friction of each joint has left in the estimate as long as it lasts.
        self._lasting = np.zeros((len(self._weights), 10))
        self._solve()

    def _shows_another_load(self, stamp):
        """Tell whether the motion filter still holds the load before the last change."""
        return self.last_change is not None and 0.0 <= stamp - self.last_change < SETTLING

    def _take(self, sample, prediction):
        load = prediction.load_columns
        weights = self._weights * (np.abs(sample.v) >= MOVING)
        self._sums.add_rows(joined_columns(prediction),
                            prediction.difference - load @ self._zero, weights)
        self._add_errors(load * weights[:, None], prediction, sample.dt)

    def _add_errors(self, weighted, prediction, dt):
        """Add the covariance that the model states of a sample's errors; weighted W K (n, 10)."""
        noise = self._residuals.load_intensity / dt + prediction.noise
        friction = np.sqrt(self._residuals.load_share * prediction.stuck)[:, None] * weighted
        # An error of that memory: its covariance with what it was before, too.
        before = self._lasting * math.exp(-dt / STUCK_TIME)
        both = friction.T @ before
        self._errors += (weighted.T * noise) @ weighted + friction.T @ friction + both + both.T
        self._lasting = before + friction

    def _solve(self):
        sums, told = self._sums, self._sums.matrix[:10, :10]
        spread = positive_solve(told + self._precision, unit(10))
        self._products = spread @ (sums.vector[:10] + self._from_prior)
        directions = sums.matrix[:10, 10:]
        misread = self._gain_doubt * sums.by_joint[:, :10] @ self._products
        errors = (self._precision + self.factor * (self._errors + directions @ directions.T)
                  + misread.T @ misread + told @ self._zero_doubt @ told)
        self._covariance = spread @ errors @ spread
        self._belief = _message(self._products, self._covariance)


def _message(products, covariance):
    """
    Return the Belief of products (10,) and their covariance (10, 10), by linearisation.

    What weighs less than its mass is known to has no place: it is told as if it weighed that
    much, which keeps it within the arm's reach and the doubt as large as it.
    """
    heavy = products.copy()
    heavy[0] = math.copysign(max(abs(products[0]), math.sqrt(covariance[0, 0])), products[0])
    mean = message_from_products(heavy)
    inverse = np.linalg.inv(products_jacobian_of_message(mean))
    mean[0] = products[0]
    return Belief(mean, inverse @ covariance @ inverse.T)
