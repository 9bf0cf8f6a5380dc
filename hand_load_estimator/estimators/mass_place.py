"""
The posterior of mass and centre of mass alone, and of the inertia given them (E2.3, E4.1).

In the linear domain the sums of a regression say all about every candidate, so a density can be
asked for anywhere, exactly, however many samples went by. The inertia about the centre of mass is
marginalised with its prior; given mass and place, the torque is linear in it.
"""

import numpy as np

from ..load import products_and_jacobian_of_shape, products_from_shape


class MassPlacePosterior:
    """
    Log density of (mass [kg], centre of mass [m]).

    matrix (10, 10), vector (10,): information about the products; prior: LoadPrior; mass [kg]:
    about what is held, which tells how large an inertia may be.
    """

    def __init__(self, matrix, vector, prior, mass):
        self._matrix, self._vector, self._prior = matrix, vector, prior
        shape = np.concatenate([[max(mass, 1e-3)], prior.mean[1:]])
        # Columns of the inertia's unit-variance doubt.
        _, jacobian = products_and_jacobian_of_shape(shape)
        doubt = jacobian[:, 4:] * prior.std[4:]
        seen = matrix @ doubt
        kept = np.linalg.solve(np.eye(6) + doubt.T @ seen, seen.T)
        self._share = matrix - seen @ kept
        self._share_vector = vector - kept.T @ (doubt.T @ vector)

    def products(self, candidates):
        """Return products (N, 10) of candidates (N, 4) with the prior's inertia."""
        inertia = np.broadcast_to(self._prior.mean[4:], (len(candidates), 6))
        return products_from_shape(np.hstack([candidates, inertia]))

    def log_density(self, candidates, products=None, scale=1.0):
        """
        Return (N,), up to a constant; minus infinity for negative masses.

        products (N, 10): of the candidates, where known; scale: how many times wider than stated
        the residual's variance is.
        """
        products = self.products(candidates) if products is None else products
        data = (products * (self._share_vector - 0.5 * (products @ self._share))).sum(-1)
        away = (candidates - self._prior.mean[:4]) / self._prior.std[:4]
        return np.where(candidates[:, 0] < 0.0, -np.inf,
                        data / scale - 0.5 * (away ** 2).sum(-1))

    def curvature(self, place, scale=1.0):
        """Return the covariance (4, 4) that the density's curvature at a candidate (4,) says."""
        shape = np.concatenate([place, self._prior.mean[4:]])
        _, jacobian = products_and_jacobian_of_shape(shape)
        hessian = jacobian[:, :4].T @ self._share @ jacobian[:, :4] / scale
        std = self._prior.std[:4]
        return np.linalg.inv(hessian * np.outer(std, std) + np.eye(4)) * np.outer(std, std)

    def inertia_given(self, place, scale=1.0):
        """Return InertiaGiven a candidate (4,)."""
        return InertiaGiven(self._matrix / scale, self._vector / scale, self._prior, place)


class InertiaGiven:
    """
    Normal density of the six inertia parameters per mass [m^2], in shape order, given the others.

    mean (6,), covariance (6, 6); slope (6, 4): what the mean moves by with mass and place.
    """

    def __init__(self, matrix, vector, prior, place):
        shape = np.concatenate([[max(place[0], 1e-3)], place[1:], prior.mean[4:]])
        products, jacobian = products_and_jacobian_of_shape(shape)
        doubt = jacobian[:, 4:] * prior.std[4:]
        inverse = np.linalg.inv(np.eye(6) + doubt.T @ matrix @ doubt)
        std = prior.std[4:]
        gain = (std[:, None] * inverse) @ doubt.T
        self.mean = prior.mean[4:] + gain @ (vector - matrix @ products)
        self.slope = -gain @ matrix @ jacobian[:, :4]
        self.covariance = inverse * np.outer(std, std)
        self._precision = np.linalg.inv(self.covariance)

    def log_density(self, candidates, where, others):
        """Return (N,) for candidates (N, k) of the parameters `where`, the others (6,) given."""
        away = np.broadcast_to(others - self.mean, (len(candidates), 6)).copy()
        away[:, where] = candidates - self.mean[where]
        return -0.5 * ((away @ self._precision) * away).sum(-1)
