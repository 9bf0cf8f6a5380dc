"""An arm that is led along a motion and tells what it reports: another's, without its effects."""

from .plant import Plant


class LedPlant(Plant):
    """
    A Plant that does not drive itself but is led along the true motion of another.

    Built with the other's arguments and no effects it has the other's draws, so that what the two
    report differs by what the effects do, along the very same motion at the same temperatures.
    """

    def follow(self, other):
        """
        Go to where another Plant of the same arm is by now, one sensor period or none on.

        Returns what is reported there (n,) [Nm], before noise, steps and torque constants.
        """
        position, velocity, acceleration, _ = other.state()
        gear, sensor = other.true_temperatures()
        torque = self._arm.required_torque(position, velocity, acceleration)
        passed = other.time - self._led_until
        if passed > 0.0:
            self._friction.set_temperature(gear)
            # By the way made and not the speed at its end, so that all ways add up.
            self._friction.step((position - self._led_to) / passed,
                                torque - self.truth.rotor * acceleration, passed)
        self._led_until, self._led_to = other.time, position
        if self.robot.file.effort.kind == 'link_torque':
            torque -= self.truth.rotor * acceleration
        else:
            torque += self._friction.torque
        return self._sensors.reported(torque, sensor, position)

    def _settle(self, robot, difficulty, rng):
        super()._settle(robot, difficulty, rng)
        self._led_until, self._led_to = self.time, self._arm.position.copy()
