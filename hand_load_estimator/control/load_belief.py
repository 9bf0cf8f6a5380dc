"""What the controller takes the load to be: products with covariance, from two sources."""

from dataclasses import dataclass, replace

import numpy as np

from ..load import products_from_message, products_jacobian_of_message


@dataclass(frozen=True)
class LoadBelief:
    """
    A load for torque computations, in products (the frame and order of load_while_sliding).

    mean (10,); covariance (10, 10); source: `estimate` or `rated`.
    """

    mean: np.ndarray
    covariance: np.ndarray
    source: str

    def torque(self, regressor):
        """Return mean (n,) and standard deviation (n,) of the load's torque K m [Nm]."""
        variance = np.einsum('ij,jk,ik->i', regressor, self.covariance, regressor)
        return regressor @ self.mean, np.sqrt(np.maximum(variance, 0.0))


def belief_of_estimate(mean, covariance):
    """
    Return the belief of an estimate: mean (10,) and covariance (10, 10) in message order.

    The covariance goes over by the Jacobian; mass x centre of mass also gets its exact second
    moment Var m Cov c + cov(m, c) cov(m, c)^T, which dominates when nothing is known yet.
    """
    mean, covariance = np.asarray(mean, dtype=float), np.asarray(covariance, dtype=float)
    jacobian = products_jacobian_of_message(mean)
    products = jacobian @ covariance @ jacobian.T
    cross = covariance[0, 1:4]
    products[1:4, 1:4] += covariance[0, 0] * covariance[1:4, 1:4] + np.outer(cross, cross)
    return LoadBelief(products_from_message(mean), products, 'estimate')


def beside(belief, products):
    """Return the belief of a load together with known products (10,), a tool's for example."""
    # What is not known of them stands in the estimate's own covariance.
    return replace(belief, mean=belief.mean + products)


def rated_belief(robot):
    """Return the conservative fixed load of E8.3: the rated load, taken as certain."""
    return LoadBelief(robot.rated_load.to_products(), np.zeros((10, 10)), 'rated')


def any_rated_belief(robot, sigma):
    """
    Return the belief that says only: some load between none and the rated one is held.

    `sigma` standard deviations reach from half the rated load to none and to all of it, and at
    the same time move its centre of mass by the rated distance in any direction (a data sheet
    names the distance from the flange, not the side). For thresholds, which must hold for every
    such load. Raises ValueError for a sigma that is not positive.
    """
    if not sigma > 0.0:
        raise ValueError(f'sigma is {sigma}; it must be positive')
    rated = robot.rated_load
    half = 0.5 * rated.to_products()
    aside = np.zeros((10, 10))
    aside[1:4, 1:4] = (rated.mass * np.linalg.norm(rated.com)) ** 2 * np.eye(3)
    # Twice: |a| + |b| <= sqrt(2 (a^2 + b^2)), both at their ends.
    return LoadBelief(half, 2.0 * (np.outer(half, half) + aside) / sigma ** 2, 'rated')
