"""A method whose intervals were made true on held-out draws (`hand_load calibrate`)."""

import numpy as np

from ..learning.stated_factors import calibrated
from .method import Belief

ALL = range(10)


class Calibrated:
    """
    A Method that states the deviations of another with factors on them, correlations kept.

    What of load changes, contacts and torques that do not fit it says is the other's, and a
    checkpoint of either serves both; what is determined, whether a mass is possible and how far
    the residual watch trusts the load follow the deviations stated here.

    method: as built, before any data. Draws were judged from the first motion on: from what was
    known of the mass then to what is believed of it before, all factors go over into 1.
    """

    def __init__(self, method, intervals):
        self._method, self._intervals = method, intervals
        self._before = 0.5 * np.log(method.belief().covariance[0, 0])
        self._way = max(self._before - intervals.knots[0, -1], 1e-6)

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
        known = np.clip((self._before - np.log(std[0])) / self._way, 0.0, 1.0)
        factor = (wide / std) ** known
        return Belief(belief.mean, belief.covariance * np.outer(factor, factor))
