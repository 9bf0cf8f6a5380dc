"""A method whose intervals were made true on held-out draws (`hand_load calibrate`)."""

import numpy as np

from ..learning.stated_factors import calibrated
from .method import Belief

ALL = range(10)


class Calibrated:
    """
    A Method that states the deviations of another with factors on them, correlations kept.

    Whatever it does besides is the other's: it looks for changes, contacts and mismatch with what
    that one states, and a checkpoint of either serves both.
    """

    def __init__(self, method, intervals):
        self._method, self._intervals = method, intervals

    def __getattr__(self, name):
        if name.startswith('_'):
            raise AttributeError(name)
        return getattr(self._method, name)

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        return self._true(self._method.update(sample, prediction))

    def belief(self):
        """Return the present Belief."""
        return self._true(self._method.belief())

    def _true(self, belief):
        std = np.sqrt(np.diagonal(belief.covariance))
        wide = calibrated(std, ALL, self._intervals.knots, self._intervals.factors)
        factor = wide / np.maximum(std, 1e-300)
        return Belief(belief.mean, belief.covariance * np.outer(factor, factor))
