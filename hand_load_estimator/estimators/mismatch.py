"""Tell a residual that neither load nor model explains for a second; see contact_gate.py too."""

import numpy as np

# The mean squared ratio of residual to what is expected of it, over this memory [s] ...
MEMORY = 1.0
# ... is a mismatch above this: four standard deviations, for a second on end.
LIMIT = 16.0


class MismatchWatch:
    """
    Follow each joint's innovation against its expected variance.

    joints: names; rmse (n,) [Nm]: residual of the torque model on held-out data.
    """

    def __init__(self, joints, rmse):
        self._joints, self._variance = joints, rmse ** 2
        self.clear()

    def clear(self):
        """Forget the past."""
        self._ratio, self.reason = np.zeros(len(self._joints)), ''

    def update(self, innovation, expected, dt):
        """Take an innovation (n,) [Nm] and its variance (n,) beside the model's noise [Nm^2]."""
        ratio = innovation ** 2 / (self._variance + expected)
        self._ratio += min(dt / MEMORY, 1.0) * (ratio - self._ratio)
        worst = int(np.argmax(self._ratio))
        self.reason = '' if self._ratio[worst] <= LIMIT else (
            f'lasting misfit: {self._joints[worst]}: residual torque '
            f'{np.sqrt(self._ratio[worst]):.1f} times what load and model explain')
