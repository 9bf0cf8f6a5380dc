"""
Notice a load change while the arm stands.

At rest friction hides small changes, but not large ones: a joint's friction lies between its two
Coulomb levels, so a torque beyond that from what model and believed load explain has another
cause. What stays hidden is found when the arm moves (change.py).
"""

import numpy as np

# Faster or harder than this [rad/s], [rad/s^2] the arm does not stand: the load's inertia shows.
STILL, UNFORCED = 0.02, 0.3
# The torque must be beyond for so long [s], or it is a knock or the arm settling.
LASTING = 0.1
# Static friction exceeds the Coulomb level; noise and belief count in standard deviations.
MARGIN, SIGMAS = 1.3, 4.0


class RestWatch:
    """
    Compare a standing arm's innovation with what friction and belief can explain.

    noise (n,) [Nm]: residual RMS of the torque model.
    """

    def __init__(self, noise):
        self._variance = noise ** 2
        self.restart()

    def restart(self):
        """Begin anew, as after a change."""
        self._beyond = 0.0

    def update(self, sample, innovation, spread, friction):
        """
        Take a MotionSample, its innovation (n,) [Nm] and the belief's variance of it [Nm^2];
        friction (n,) [Nm]: the level that joints can hold.

        Return whether the load has changed.
        """
        if np.abs(sample.v).max() > STILL or np.abs(sample.a).max() > UNFORCED:
            self._beyond = 0.0
            return False
        limit = MARGIN * friction + SIGMAS * np.sqrt(self._variance + spread)
        self._beyond = self._beyond + sample.dt if (np.abs(innovation) > limit).any() else 0.0
        if self._beyond < LASTING:
            return False
        self.restart()
        return True
