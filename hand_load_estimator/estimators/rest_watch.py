"""
Notice a load change while the arm stands.

At rest friction hides small changes, but not large ones: a joint's friction may be anywhere
between its two Coulomb levels, so a torque that moves by more than twice the level without the
joint moving has another cause. What stays hidden is found when the arm moves (change.py).
"""

import numpy as np

# A joint that stays within this [rad] stands, also while it sags under a new load ...
STANDING = 0.02
# ... and its torque is settled this long [s] after the last motion beyond it.
SETTLED = 0.4
# Faster or harder than this [rad/s], [rad/s^2] the load's inertia shows, not only its weight.
STILL, UNFORCED = 0.02, 0.3
# A step must last this long [s], or it is a knock.
LASTING = 0.1
# Part of the range between the Coulomb levels that friction may wander through, and noise.
MARGIN, NOISE_MARGIN = 1.2, 4.0


class RestWatch:
    """
    Compare the torque difference of a standing arm with what it was when it came to stand.

    level, noise (n,) [Nm]: Coulomb level and residual RMS of the torque model.
    """

    def __init__(self, level, noise):
        self._limit = 2.0 * MARGIN * level + NOISE_MARGIN * noise
        self.restart()

    def restart(self):
        """Forget where the arm stood."""
        self._anchor, self._standing, self._beyond = None, 0.0, 0.0
        self._sum, self._count = 0.0, 0

    def update(self, sample, difference):
        """Take a MotionSample and its torque difference (n,); tell whether the load changed."""
        if self._anchor is None or (np.abs(sample.q - self._anchor) > STANDING).any():
            self.restart()
            self._anchor = sample.q
            return False
        if (np.abs(sample.v) > STILL).any() or (np.abs(sample.a) > UNFORCED).any():
            self._beyond = 0.0
            return False
        self._standing += sample.dt
        if self._standing < SETTLED:
            # The second half of settling is the reference.
            if self._standing > 0.5 * SETTLED:
                self._sum, self._count = self._sum + difference, self._count + 1
            return False
        if not self._count:
            return False
        step = np.abs(difference - self._sum / self._count) > self._limit
        self._beyond = self._beyond + sample.dt if step.any() else 0.0
        if self._beyond < LASTING:
            return False
        self.restart()
        return True
