"""A Gaussian process seen through its inducing points: mean and variance in numpy (E2.1)."""

import numpy as np


class InducingPoints:
    """
    One Gaussian process per joint with a Matern 5/2 kernel, its posterior precomputed.

    tensors: points (n, M, D); lengthscale (n, D); outputscale (n,); mean_weights (n, M);
    shrink (n, M, M): what data took from the prior's variance, k(x, x) - k(x, Z) shrink k(Z, x).
    """

    SHAPES = {'points': 'nMD', 'lengthscale': 'nD', 'outputscale': 'n', 'mean_weights': 'nM',
              'shrink': 'nMM'}

    def __init__(self, tensors):
        # The factor of the Matern kernel's distance is put into the lengths once.
        self._rate = np.sqrt(5.0) / tensors['lengthscale']
        self._points = tensors['points'] * self._rate[:, None, :]
        self._level = tensors['outputscale']
        self._mean, self._shrink = tensors['mean_weights'], tensors['shrink']

    def at(self, x):
        """Return mean and variance (..., n) at inputs x (..., n, D)."""
        k = matern(self._points, (x * self._rate)[..., None, :], self._level)
        spent = (k[..., None, :] @ self._shrink)[..., 0, :]
        # Rounding must not make a certain place less than certain.
        variance = np.maximum(self._level - (spent * k).sum(-1), 1e-9 * self._level)
        return (k * self._mean).sum(-1), variance


def matern(points, x, level):
    """Return k(x, points) (..., n, M) for places scaled by sqrt(5) / lengthscale, level (n,)."""
    square = ((x - points) ** 2).sum(-1)
    distance = np.sqrt(square)
    return level[:, None] * (1.0 + distance + square / 3.0) * np.exp(-distance)
