"""
The torque an arm without load would show: torque model plus learned difference (E2.2).

tau_est = tau_mdl + gain * mean of the learned function, joint by joint; the offset torque dtau =
tau_real - tau_est belongs to the load. What the function does not know of the place it is asked
about, and what of its mean is not subtracted, widens the error a sample is expected to have
(E6.4).
"""

from dataclasses import replace

import numpy as np

from ..learning.difference_inputs import difference_inputs
from ..learning.left_out import unexplained
from ..torque.columns import warmth_of

# An error of the function lasts about as long [s] as a joint stays at one speed; as a coloured
# error of that memory its density is 2 variance time.
MEMORY = 0.5
# A few recordings hardly prove that the function takes more than this off the residual.
LEAST_SHARE = 0.5


class DifferenceFunction:
    """
    Mean and variance of the no-load torque difference of a DifferenceArtefact, as it is used.

    doubt: the standard deviation about what was subtracted at the last sample, over the one it
    usually had on recordings left out, of the joint with the largest, of those where
    something is subtracted (E6.4); 0 before any sample.
    """

    def __init__(self, model, artefact):
        self._robot, self._artefact = model.robot, artefact
        self._used = artefact.gain > 0.0
        share = np.clip(artefact.share, LEAST_SHARE, None)
        self._gained = (1.0 - share) * model.residuals.load_intensity
        self._expected = artefact.left_out_variance
        self.doubt = 0.0

    @property
    def fingerprint(self):
        """Numbers that differ where another function was learned."""
        return self._artefact.fingerprint

    def mean_and_variance(self, q, v, a, temperature):
        """Return what to subtract [Nm] (n,) and the variance [Nm^2] (n,) about it."""
        artefact = self._artefact
        x = difference_inputs(artefact.inputs, q, v, a, warmth_of(self._robot, temperature))
        mean, variance = artefact.predictor.at(x)
        return (artefact.gain * mean * artefact.scale,
                unexplained(mean, variance, artefact.gain) * artefact.scale ** 2)

    def corrected(self, sample, prediction):
        """Return the Prediction with dtau for its difference and the function's doubt."""
        mean, variance = self.mean_and_variance(sample.q, sample.v, sample.a, sample.temperature)
        usual = self._expected * self._artefact.scale ** 2
        self.doubt = float(np.sqrt((variance / usual)[self._used].max(initial=0.0)))
        # Recordings left out have shown the error of places like theirs already.
        surplus = np.maximum(variance - usual, 0.0)
        return replace(prediction, difference=prediction.difference - mean,
                       density=prediction.density - self._gained + 2.0 * MEMORY * surplus)
