"""Method `gp_bayes`: learned no-load difference, then Bayesian regression (E2.2, eq. 13-14)."""

import numpy as np

from .bayes import Bayes


class GpBayes(Bayes):
    """`bayes` on the offset torque that a DifferenceFunction leaves, weighed by its variance."""

    name = 'gp_bayes'

    def __init__(self, model, uncertainties, function):
        super().__init__(model, uncertainties)
        self._function = function

    @property
    def reliability(self):
        """What the learned function says of the torques it was asked for (E6.4), by name."""
        return {'doubt of the learned torque over its usual one': self._function.doubt}

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        return super().update(sample, self._function.corrected(sample, prediction))

    def state(self):
        """Return the state of `bayes`, and whose function it was found with."""
        return {**super().state(), 'function': self._function.fingerprint}

    def restore(self, state):
        """Go on from a state() of the same learned function."""
        if not np.array_equal(state.get('function'), self._function.fingerprint):
            raise ValueError('it comes from another learned torque difference')
        super().restore({name: value for name, value in state.items() if name != 'function'})
