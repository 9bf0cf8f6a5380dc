"""Method `gp_bayes`: learned no-load difference, then Bayesian regression (E2.2, eq. 13-14)."""

from .bayes import Bayes
from .method import check_origin


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
        check_origin(state, 'function', self._function.fingerprint, 'learned torque difference')
        super().restore(state)
