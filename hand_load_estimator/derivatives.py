"""
Velocity and acceleration from two measurements of one motion: position and velocity.

An encoder of microradians tells an acceleration better than a velocity signal does, a coarse one
tells it worse, and stamps that jitter spoil the position of a moving joint only. Which of them
holds is seen in the data: both stand behind the same filter and show the same motion, so their
difference is noise alone, and the weighted mean of least variance follows from how that
difference agrees with either of them (Bates and Granger 1969, The combination of forecasts).
"""

import numpy as np

# Noise is told from motion by fourth differences, which see hardly anything of a motion.
_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
# Samples over which it is averaged, and as many for which the velocity is believed at the start.
_MEMORY, _ASSUMED = 250, 5
# A joint that stands shows no steps of its encoder [rad/s].
_STANDS = 0.02


class Derivatives:
    """
    Weigh what position and velocity say of n joints' motion.

    Until something was seen the velocity is believed.
    """

    def __init__(self, n):
        self._last = []
        self._count, self._apart, self._agreeing = np.zeros((3, n))

    def restart(self):
        """Begin the differences anew, as after a gap; what was learned of the noise stays."""
        self._last = []

    @property
    def share(self):
        """Weight (n,) of the position, 0 to 1."""
        believed = self._count / (self._count + _ASSUMED)
        return believed * np.clip(self._agreeing / np.maximum(self._apart, 1e-30), 0.0, 1.0)

    def update(self, of_position, of_velocity):
        """
        Return velocity [rad/s] and acceleration [rad/s^2] (2, n) of least noise.

        of_position, of_velocity (2, n): the same as either signal has them.
        """
        self._last = [*self._last[-4:], (of_position[1], of_velocity[1])]
        if len(self._last) == 5:
            position, velocity = np.einsum('k,kcn->cn', _DIFFERENCES, np.array(self._last))
            self._learn(velocity - position, velocity, np.abs(of_velocity[0]) > _STANDS)
        return of_velocity + self.share * (of_position - of_velocity)

    def _learn(self, apart, velocity, moving):
        """Take fourth differences (n,) of both accelerations' difference and of the velocity's."""
        self._count = np.minimum(self._count + moving, _MEMORY)
        step = moving / np.maximum(self._count, 1.0)
        self._apart = self._apart + step * (apart ** 2 - self._apart)
        self._agreeing = self._agreeing + step * (apart * velocity - self._agreeing)
