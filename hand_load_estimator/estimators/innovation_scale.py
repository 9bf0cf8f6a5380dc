"""
How much wider intervals have to be, told at once by innovations larger than stated.

ModelTrust asks whole windows of motion what they tell of the load. A joint whose torques differ
more than load and model explain tells sooner that the arm is not as modelled (Birge's ratio: the
errors of a fit count as much more as its residuals are larger than stated), but only what the
estimate has not taken for load already: what is too much counts several times.
"""

from dataclasses import replace

import numpy as np

# Squared innovations are averaged over this much motion of a joint [s], beside so much of it in
# which they are taken for as stated.
MEMORY, ASSUMED = 10.0, 0.1
MOVES = 0.02           # [rad/s]
# Standard deviations of such a mean that are chance; what is beyond counts so many times. Of
# development cases with an undeclared effect 88 instead of 76 % of the masses are then held, and
# as many as before of arms without.
CHANCE, EXCESS = 2.0, 4.0


class InnovationScale:
    """Follow each joint's innovation against its expected variance while it moves; n joints."""

    def __init__(self, rmse):
        """rmse (n,) [Nm]: residual of the torque model on held-out data."""
        self._variance = rmse ** 2
        self.clear()

    def clear(self):
        """Forget the past."""
        # Of squared innovations over what is expected, 1, and the step, each times the step [s].
        self.sums = np.zeros((3, len(self._variance)))

    def update(self, innovation, expected, sample):
        """Take an innovation (n,) [Nm] and its variance (n,) beside the model's noise [Nm^2]."""
        dt = min(sample.dt, ASSUMED)
        seconds = dt * (np.abs(sample.v) > MOVES)
        ratio = innovation ** 2 / (self._variance + expected)
        self.sums *= 1.0 - seconds / MEMORY
        self.sums[0] += seconds * ratio
        self.sums[1] += seconds
        self.sums[2] += seconds * dt

    def widened(self, trust):
        """Return a Trust with the factor that these innovations ask for."""
        return replace(trust, factor=trust.factor * self.beyond(trust.factor))

    def beyond(self, factor):
        """Return what variances, `factor` times what is stated already, have to grow by."""
        ratio, seconds, steps = self.sums
        # A squared normal has the variance 2; of sums, 2 times the sum of squared steps.
        beyond_chance = (ratio - seconds - CHANCE * np.sqrt(2.0 * steps)) / (ASSUMED + seconds)
        return max(1.0, (1.0 + EXCESS * beyond_chance.max()) / factor)
