"""
Notice a load change while the arm stands.

At rest friction hides small changes, but not large ones: a joint's friction lies between its two
Coulomb levels, so a torque beyond that from what model and believed load explain has another
cause. Where no other joint shows anything, that is one which holds more than the model says: a
load beyond the friction of one joint hardly leaves all others as they were. What stays hidden is
found when the arm moves (change.py).
"""

import numpy as np

# Faster or harder than this [rad/s], [rad/s^2] the arm does not stand: the load's inertia shows.
STILL, UNFORCED = 0.02, 0.3
# The torque must be beyond for so long [s], or it is a knock or the arm settling.
LASTING = 0.1
# What must be there at another joint, too, of its limit: in development arms a joint that sticks
# leaves others below 0.4, a changed load one above 0.5.
SHARE = 0.5
# Static friction exceeds the Coulomb level; noise and belief count in standard deviations.
MARGIN, SIGMAS = 1.3, 4.0

NOTHING, ONE_JOINT, SEVERAL = range(3)


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

        Return NOTHING, or what has been beyond for as long as it takes: ONE_JOINT, which may be
        pushed or stick, or SEVERAL, which may also be another load.
        """
        if np.abs(sample.v).max() > STILL or np.abs(sample.a).max() > UNFORCED:
            self._beyond = 0.0
            return NOTHING
        share = np.abs(innovation) / (
            MARGIN * friction + SIGMAS * np.sqrt(self._variance + spread))
        self._beyond = self._beyond + sample.dt if (share > 1.0).any() else 0.0
        if self._beyond < LASTING:
            return NOTHING
        self.restart()
        return SEVERAL if np.count_nonzero(share > SHARE) > 1 else ONE_JOINT
