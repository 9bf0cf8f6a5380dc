"""
Recursive Bayesian regression of the load (eq. 13, 14), in information form.

Each sample adds beta K^T K and beta K^T dtau, so the order of samples does not matter and nothing
is inverted until an estimate is wanted. Beside the ten products the regression carries what the
torque model is unsure of, and what misreads weights, as unit-variance nuisances; marginalising
them is what keeps the load's variance honest. The prior is stated in shape parameters (load.py),
where a load of unknown mass has a place and a size; a few Gauss-Newton steps join it to the data.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ..load import (message_from_shape, message_jacobian_of_shape,
                    products_and_jacobian_of_shape)
from .positive_solve import positive_solve, unit

# Gauss-Newton steps from the last solution: at most so many, and none after one shorter than this
# many standard deviations, which leaves an error of its square.
STEPS, SHORT = 3, 0.01


@dataclass(frozen=True)
class Trust:
    """
    How far the torque model is trusted, less or as much as it states (model_trust.py).

    precision (r, r): of the nuisances before any data, the identity as stated; factor: on the
    variance of everything that torques tell.
    """

    precision: np.ndarray
    factor: float = 1.0


@lru_cache
def as_stated(nuisances):
    """Return the Trust of a model that is as it states, with so many nuisances."""
    return Trust(unit(nuisances))


@dataclass(frozen=True)
class Posterior:
    """
    Gaussian belief about the load.

    shape (10,), shape_covariance (10, 10) in shape order.
    """

    shape: np.ndarray
    shape_covariance: np.ndarray

    @cached_property
    def mean(self):
        """Mean (10,) in message order."""
        return message_from_shape(self.shape)

    @cached_property
    def covariance(self):
        """Covariance (10, 10) in message order."""
        return message_covariance(self.shape, self.shape_covariance)

    @cached_property
    def _products_and_jacobian(self):
        return products_and_jacobian_of_shape(self.shape)

    @property
    def products(self):
        """The estimate u (10,) as products."""
        return self._products_and_jacobian[0]

    @cached_property
    def products_covariance(self):
        """S (10, 10): covariance of the products."""
        _, jacobian = self._products_and_jacobian
        return jacobian.dot(self.shape_covariance).dot(jacobian.T)


class Information:
    """
    Sums of data information for d = 10 + r unknowns.

    matrix (d, d) and vector (d,); by_joint (n, d, 10): each joint's columns for the load, from
    which the doubt about its torque constant is carried into the covariance; n = 0 leaves it out.
    square: of the weighted differences of rows, which tells what some unknowns leave of them;
    NaN where unknowns were taken out.
    """

    def __init__(self, n, nuisances):
        d = 10 + nuisances
        # The vector stands ahead of the matrix: one operation serves both, and what load_share
        # solves for lies side by side.
        self._sums = np.zeros((d, 1 + d))
        self.vector, self.matrix = self._sums[:, 0], self._sums[:, 1:]
        self.by_joint, self.square = np.zeros((n, d, 10)), 0.0

    def add_rows(self, columns, difference, weights):
        """Add rows: columns (., d), difference (.,) [Nm], weights (.,) = precision."""
        weighted = columns.T * weights
        self._sums += weighted.dot(np.concatenate([difference[:, None], columns], axis=1))
        self.square += float(weights.dot(difference * difference))
        if len(self.by_joint):
            self.by_joint += weighted.T[:, :, None] * columns[:, None, :10]

    def add(self, other):
        """Add another Information of the same unknowns."""
        self._sums += other._sums
        self.square += other.square
        if len(self.by_joint):
            self.by_joint += other.by_joint

    def take_off(self, other, share):
        """Subtract a share in [0, 1] of another Information of the same unknowns."""
        self._sums -= share * other._sums
        self.square -= share * other.square
        self.by_joint -= share * other.by_joint

    def plus(self, other):
        """Return the sum with another Information of the same unknowns."""
        out = Information(len(self.by_joint), len(self.vector) - 10)
        np.add(self._sums, other._sums, out=out._sums)
        out.square = self.square + other.square
        np.add(self.by_joint, other.by_joint, out=out.by_joint)
        return out

    def scale(self, factor):
        """Forget: multiply everything by a factor in [0, 1]."""
        self._sums *= factor
        self.square *= factor
        self.by_joint *= factor

    def left_by(self, unknowns):
        """Return the weighted square of what unknowns (d,) leave of the differences."""
        return self.square + unknowns.dot(self.matrix.dot(unknowns) - 2.0 * self.vector)

    def without_last(self, count, trust=None):
        """
        Return an Information of the same size without the last `count` nuisances' data.

        They are marginalised with the prior of a Trust, as if their values were drawn anew from
        here on: what was learnt of the others stays, as well as it was known.
        """
        kept = len(self.vector) - count
        out = Information(len(self.by_joint), len(self.vector) - 10)
        last = slice(kept - 10, None)
        inner = self.matrix[kept:, kept:] + (trust or self._stated()).precision[last, last]
        share = np.linalg.solve(inner, self.matrix[kept:, :kept]).T
        out.matrix[:kept, :kept] = self.matrix[:kept, :kept] - share @ self.matrix[kept:, :kept]
        out.vector[:kept] = self.vector[:kept] - share @ self.vector[kept:]
        out.by_joint[:, :kept] = self.by_joint[:, :kept] - share @ self.by_joint[:, kept:]
        out.square = np.nan
        return out

    def load_share(self, trust=None):
        """
        Return (10, 10), (10,): information of the load with the nuisances marginalised.

        trust: a Trust, or None for a model that is as it states.
        """
        trust = trust or self._stated()
        sums = self._sums
        if len(sums) > 10:
            sums = sums[:10, :11] - sums[:10, 11:].dot(
                positive_solve(self.inner(trust), sums[10:, :11]))
        matrix, scale = sums[:, 1:], 1.0 / trust.factor
        return (0.5 * scale) * (matrix + matrix.T), scale * sums[:, 0]

    def vectors_by_joint(self, products, trust=None):
        """Return (n, 10): what each joint's load torque adds to the vector of load_share."""
        trust = trust or self._stated()
        vectors = self.by_joint @ products / trust.factor
        if len(self.vector) == 10:
            return vectors
        solved = positive_solve(self.inner(trust), vectors[:, 10:].T)
        return vectors[:, :10] - solved.T @ self.matrix[10:, :10]

    def nuisance_given(self, products, trust=None):
        """Return the nuisances' mean (r,) for a known load."""
        return positive_solve(self.inner(trust or self._stated()),
                              self.vector[10:] - self.matrix[10:, :10] @ products)

    def inner(self, trust):
        """Return (r, r): information of the nuisances given the load, as a Trust has them."""
        return self.matrix[10:, 10:] + trust.precision

    def _stated(self):
        return as_stated(len(self.vector) - 10)


def shape_posterior(matrix, vector, prior, start):
    """
    Return shape (10,) and its covariance (10, 10).

    matrix, vector: information about the products; prior: LoadPrior; start: shape to begin at.
    """
    shape, std = start, prior.std
    # Jacobian and residual side by side: the same products of matrices serve both.
    sides = np.empty((10, 11))
    for _ in range(STEPS):
        sides[:, 10], jacobian = products_and_jacobian_of_shape(shape)
        # Conditioning: in units of the prior, which is 1 in every direction.
        np.multiply(jacobian, std, out=sides[:, :10])
        weighted = matrix.dot(sides)
        weighted[:, 10] = vector - weighted[:, 10]
        normal = sides[:, :10].T.dot(weighted)
        gradient = normal[:, 10] + (prior.mean - shape) / std
        inverse = positive_solve(normal[:, :10] + unit(10), unit(10))
        step = inverse.dot(gradient)
        shape = shape + std * step
        if gradient.dot(step) < SHORT ** 2:
            break
    return shape, (inverse + inverse.T) * prior.half_scale


def posterior_of(information, prior, start, gain_doubt=0.0, tare=None, trust=None):
    """
    Return the Posterior of an Information.

    gain_doubt: relative standard deviation of each joint's torque constant; tare: covariance
    (10, 10) of the products that were declared zero, or None; trust: as of load_share.
    """
    matrix, vector = share_less_tare(information, tare, trust)
    shape, covariance = shape_posterior(matrix, vector, prior, start)
    if gain_doubt > 0.0:
        covariance = covariance + gain_covariance(information, shape, covariance, gain_doubt,
                                                  trust)
    return Posterior(shape, covariance)


def share_less_tare(information, tare, trust=None):
    """Return the load_share of an Information, with the doubt about what tare declared zero."""
    matrix, vector = information.load_share(trust)
    if tare is None:
        return matrix, vector
    # An offset of covariance S_t in the products: information (L^-1 + S_t)^-1.
    shrink = np.linalg.inv(np.eye(10) + matrix @ tare)
    return shrink @ matrix, shrink @ vector


def gain_covariance(information, shape, covariance, gain_doubt, trust=None):
    """Return what doubtful torque constants add to a covariance (10, 10) in shape order."""
    # d u / d eps_i of a load torque misread by (1 + eps_i) on joint i alone.
    products, jacobian = products_and_jacobian_of_shape(shape)
    moved = covariance @ jacobian.T @ information.vectors_by_joint(products, trust).T
    return gain_doubt ** 2 * moved @ moved.T


def message_covariance(shape, covariance):
    """Return the covariance in message order of a shape belief; inertia is a product of two."""
    jacobian = message_jacobian_of_shape(shape)
    out = jacobian.dot(covariance).dot(jacobian.T)
    # Var(m g) of two unknowns has a second-order part that the linear rule leaves out.
    out.ravel()[44::11] += covariance[0, 0] * covariance.diagonal()[4:]
    return out
