"""A method whose intervals were made true on held-out draws (`hand_load calibrate`)."""

import numpy as np

from ..learning.intervals import origin_of
from .method import Belief
from .registry import with_network


class Calibrated:
    """
    A Method that states the deviations of another with factors on them, correlations kept.

    What of load changes, contacts and torques that do not fit it says is the other's, and a
    checkpoint of either serves both; what is determined, whether a mass is possible and how far
    the residual watch trusts the load (while the model explains the torques) follow the deviations
    stated here.

    method: as built for a TorqueModel, before any data. intervals: in words, which.
    """

    def __init__(self, method, intervals, model):
        self._method, self._factors = method, intervals
        self.intervals = intervals.told(origin_of(model, method))
        self._before = np.sqrt(method.belief().covariance[0, 0])

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
        factor = self._factors.of(std, self._before)
        return Belief(belief.mean, belief.covariance * np.outer(factor, factor))


def intervals_of(method):
    """Return in words where the deviations that a Method states come from."""
    if isinstance(method, Calibrated):
        return method.intervals
    if with_network(method.name) and getattr(method, 'asked', True):
        return 'calibrated with the network'
    return 'as the method has them'
