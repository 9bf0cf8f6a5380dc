"""What the robot reports: encoder, velocity, effort and temperature with noise and steps."""

import numpy as np


class Sensors:
    """
    Measure n joints as the robot file's effort kind says.

    noise (n,) [Nm]: standard deviation of the effort in torque units.
    """

    def __init__(self, robot, truth, difficulty, rng):
        self._robot, self._truth, self._difficulty, self._rng = robot, truth, difficulty, rng
        self.noise = truth.noise
        self._quantum = difficulty.torque_quantum * truth.noise
        self._sigma = np.array([np.full(robot.n, difficulty.position_noise),
                                np.full(robot.n, difficulty.velocity_noise), truth.noise])

    def measure(self, position, velocity, torque, temperature):
        """Return position, velocity, effort (n,) of true values and motor temperature (n,)."""
        noise = self._rng.standard_normal(self._sigma.shape)
        noise *= self._sigma
        measured = _rounded(position + noise[0], self._difficulty.position_quantum)
        effort = self.reported(torque, temperature, position) + noise[2]
        return (measured, velocity + noise[1],
                _rounded(effort, self._quantum) / self._truth.constants)

    def reported(self, torque, temperature, position):
        """Return the torque (n,) the robot believes in, before noise."""
        truth = self._truth
        warmer = temperature - self._robot.file.reference_temperature
        torque = saturated(torque, truth.effort_bend)
        reported = torque * (truth.effort_gain + truth.effort_gain_slope * warmer)
        reported += truth.effort_offset
        return reported - self._robot.configured_torque(position)

    def temperatures(self, sensor):
        """Return reported temperatures (n,) [degC] of the sensors' nodes."""
        noise = self._difficulty.temperature_noise * self._rng.standard_normal(len(sensor))
        return _rounded(sensor + noise, self._difficulty.temperature_quantum)


def saturated(torque, bend):
    """Return what is reported of torques (..., n) [Nm] by drives that end softly at 1 / bend."""
    if not np.count_nonzero(bend):
        return torque
    # None at all is one too small to tell.
    bend = np.maximum(bend, 1e-12)
    return np.tanh(bend * torque) / bend


def _rounded(value, quantum):
    """Round to multiples of quantum, one or (n,), all or none of them zero: no rounding."""
    if not np.count_nonzero(quantum):
        return value
    return np.rint(value / quantum) * quantum
