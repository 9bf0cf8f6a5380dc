"""An arm that is led along a motion and tells what torque that takes: itself, or without effects."""

import numpy as np

from .plant import Plant


class LedPlant(Plant):
    """
    A Plant that does not drive itself but is led along the motion of another.

    Built with another's arguments it has the other's draws; of two of them, one with hidden
    effects and one without, the torques differ by what the effects do along the very same motion.
    """

    def follow(self, other, position, velocity):
        """
        Go to where another Plant of the same arm is by now, in the steps of its simulation.

        position, velocity (n,): as it measured them, or as they are. Returns what its drives have
        to supply there (n,) [Nm], or what goes through the gears if that is what is reported.
        """
        _, _, acceleration, _ = other.state()
        self._friction.set_temperature(other.true_temperatures()[0])
        self._situation.temperature = other.true_temperatures()[0]
        now = np.array([position, velocity, acceleration])
        before, steps = self._led_to, int(round((other.time - self.time) / self._dt))
        for k in range(steps):
            self._lead(before + (k + 1) / steps * (now - before), (now - before)[0] / steps)
        self._led_to = now
        torque = self._situation.gear_torque
        if self.robot.file.effort.kind == 'link_torque':
            return torque.copy()
        return torque + self.truth.rotor * acceleration + self._friction.torque

    def report(self, torque, other):
        """Return what is reported (n,) [Nm] of a torque of its drives where `other` is by now."""
        return self._sensors.reported(torque, other.true_temperatures()[1], self._arm.position)

    def _lead(self, state, way):
        """Be led a step on to position, velocity, acceleration (3, n), by a way (n,)."""
        self._steps += 1
        if self.truth.held and (now := self._held_now()) != self._held:
            self._hang(now)
        # By the way made and not the speed at its end, so that all ways add up.
        self._friction.step(way / self._dt, self._situation.gear_torque, self._dt)
        torque = self._arm.required_torque(*state)
        self._situation.time = self.time
        self._situation.position, self._situation.velocity = self._arm.position, self._arm.velocity
        self._act()
        self._situation.gear_torque[:] = torque + self._hidden - self.truth.rotor * state[2]

    def _settle(self, robot, difficulty, rng):
        super()._settle(robot, difficulty, rng)
        self._led_to = np.array([self._arm.position, self._arm.velocity, self._arm.acceleration])
