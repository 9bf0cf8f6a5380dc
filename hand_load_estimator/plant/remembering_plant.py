"""An arm that tells how much of its friction is still what its bristles held at the start."""

import numpy as np

from .plant import Plant

# Of the start's standard deviation: small against the bends of the bristles' law, large against
# rounding.
_SHIFT = 1e-4


class RememberingPlant(Plant):
    """
    A Plant with a second set of bristles, led along the same motion from a start beside its own.

    The difference of the two is the derivative of friction by its start. The second set moves
    nothing: built with the same arguments as a Plant it moves and reports as that one does.
    """

    @property
    def start_std(self):
        """Standard deviation (n,) [Nm] of the friction torque at the start, as it is drawn."""
        return self._friction.start_std

    def start_left(self):
        """
        Return d(reported torque now) / d(friction torque at the start) (n,) [-].

        1 while the contacts of a joint only bend, 0 once they slide: its friction then depends
        on the way since and no more on the start. Behind the gear no friction is reported.
        """
        if self.robot.file.effort.kind == 'link_torque':
            return np.zeros(self.robot.n)
        return (self._beside.torque - self._friction.torque) / self._shift

    def _settle(self, robot, difficulty, rng):
        super()._settle(robot, difficulty, rng)
        # Towards the middle, where both are off the level they slide at.
        side = np.where(self._friction.torque > 0.0, -1.0, 1.0)
        self._shift = _SHIFT * side * self.start_std
        self._beside = self._friction.shifted(self._shift)

    def _step(self):
        # Both see the temperature and the gears' torque from before this step.
        gear_torque = self._situation.gear_torque.copy()
        self._beside.set_temperature(self._thermal.gear)
        super()._step()
        self._beside.step(self._arm.velocity, gear_torque, self._dt)
