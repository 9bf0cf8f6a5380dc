"""
The torque an arm without load would show: torque model plus learned difference (E2.2).

tau_est = tau_mdl + mean of the learned function; the offset torque dtau = tau_real - tau_est
belongs to the load. What the function does not know of the place it is asked about widens the
error a sample is expected to have (E6.4).
"""

from dataclasses import replace

import numpy as np

from ..learning.difference_inputs import difference_inputs
from ..torque.columns import warmth_of

# An error of the function lasts about as long [s] as a joint stays at one speed; as a coloured
# error of that memory its density is 2 variance time.
MEMORY = 0.5
# A few recordings hardly prove that the function takes more than this off the residual.
LEAST_SHARE = 0.5


class DifferenceFunction:
    """
    Mean and variance of the no-load torque difference of a DifferenceArtefact.

    doubt: the function's standard deviation at the last sample over the one it usually had on
    recordings left out, of the joint with the largest (E6.4); 0 before any sample.
    """

    def __init__(self, model, artefact):
        self._robot, self._artefact = model.robot, artefact
        share = np.clip(artefact.share, LEAST_SHARE, None)
        self._gained = (1.0 - share) * model.residuals.load_intensity
        self._expected = artefact.left_out_variance
        self.doubt = 0.0

    @property
    def fingerprint(self):
        """Numbers that differ where another function was learned."""
        return self._artefact.fingerprint

    def mean_and_variance(self, q, v, a, temperature):
        """Return mean [Nm] and variance [Nm^2] (n,) of tau_real - tau_mdl without load."""
        artefact = self._artefact
        x = difference_inputs(artefact.inputs, q, v, a, warmth_of(self._robot, temperature))
        mean, variance = artefact.predictor.at(x)
        return mean * artefact.scale, variance * artefact.scale ** 2

    def corrected(self, sample, prediction):
        """Return the Prediction with dtau for its difference and the function's doubt."""
        mean, variance = self.mean_and_variance(sample.q, sample.v, sample.a, sample.temperature)
        usual = self._expected * self._artefact.scale ** 2
        self.doubt = float(np.sqrt((variance / usual).max()))
        # Recordings left out have shown the error of places like theirs already.
        surplus = np.maximum(variance - usual, 0.0)
        return replace(prediction, difference=prediction.difference - mean,
                       density=prediction.density - self._gained + 2.0 * MEMORY * surplus)
