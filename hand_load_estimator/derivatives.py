"""
Velocity and acceleration from two measurements of one motion: position and velocity.

An encoder of microradians tells an acceleration better than a velocity signal does, a coarse one
tells it worse, and stamps that jitter spoil the position of a moving joint only. Which of them
holds is seen in the data: both stand behind the same filter and show the same motion, so their
difference is noise, and the weighted mean of least variance follows from how that difference
agrees with either of them (Bates and Granger 1969, The combination of forecasts). The weight is
the acceleration's; the velocity has the same one, to stay its integral.
"""

import numpy as np

# Noise is told from motion by fourth differences, which see hardly anything of a motion.
_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
# A row for each place that the newest of five samples may have in a ring.
_RING = np.array([np.roll(_DIFFERENCES, k + 1) for k in range(5)])
# Samples over which it is averaged, and as many for which the velocity is believed at the start.
_MEMORY, _ASSUMED = 250, 5
# From so many on a sample counts as no more than so many times the mean: one false reading of a
# sensor would outweigh minutes of true ones.
_SETTLED, _LARGEST = 25, 4.0
# A joint that stands shows no steps of its encoder [rad/s].
_STANDS = 0.02


class Derivatives:
    """
    Weigh what position and velocity say of n joints' motion.

    share (n,): weight of the position, 0 to 1. Until something was seen the velocity is believed.
    """

    def __init__(self, n):
        self._ring, self._taken = np.zeros((5, 2 * n)), 0
        self._count, self._apart, self._agreeing, self.share = np.zeros((4, n))

    def restart(self):
        """Begin the differences anew, as after a gap; what was learned of the noise stays."""
        self._taken = 0

    def update(self, of_position, of_velocity):
        """
        Return velocity [rad/s] and acceleration [rad/s^2] (2, n) of least noise.

        of_position, of_velocity (2, n): the same as either signal has them.
        """
        apart, place = of_position - of_velocity, self._taken % 5
        self._ring[place] = np.concatenate([apart[1], of_velocity[1]])
        self._taken += 1
        if self._taken >= 5:
            self._learn(*_RING[place].dot(self._ring).reshape(2, -1),
                        np.abs(of_velocity[0]) > _STANDS)
        return of_velocity + self.share * apart

    def _learn(self, apart, velocity, moving):
        """Take fourth differences (n,) of what lies between both accelerations and of velocity."""
        self._count = np.minimum(self._count + moving, _MEMORY)
        step = moving / np.maximum(self._count, 1.0)
        square = apart * apart
        usual = np.where(self._count < _SETTLED, np.inf, _LARGEST * self._apart)
        step *= np.minimum(1.0, usual / np.maximum(square, 1e-30))
        self._apart += step * (square - self._apart)
        # Where they are apart it is by the velocity's noise as far as both go the other way.
        self._agreeing -= step * (apart * velocity + self._agreeing)
        believed = self._count / (self._count + _ASSUMED)
        self.share = believed * np.clip(self._agreeing / np.maximum(self._apart, 1e-30), 0.0, 1.0)
