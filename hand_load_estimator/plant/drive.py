"""
The drives: position control over velocity control, with feed-forward from the robot file.

A real controller computes the torque of its set point from its own (nominal) model and leaves
what that misses, load and friction, to the velocity loop's integrator; the arm follows within
milliradians, not exactly.
"""

import numpy as np

from .difficulty import by_size

POSITION_GAIN = 25.0       # [1/s]
VELOCITY_BANDWIDTH = 80.0  # [1/s] velocity loop on the nominal inertia
INTEGRAL_RATE = 10.0       # [1/s] of the velocity loop's integrator


def _tuning_inertia(robot, difficulty):
    """Return the inertia (n,) [kg m^2] a commissioning engineer tunes for: mean over poses."""
    rng = np.random.default_rng(0)
    low = np.maximum(robot.limits.lower, -np.pi)
    high = np.minimum(robot.limits.upper, np.pi)
    poses = rng.uniform(low, high, (50, robot.n))
    mean = np.mean([np.diag(robot.mass_matrix(q)) for q in poses], axis=0)
    return np.abs(mean) + by_size(difficulty.rotor_inertia, robot.file.max_torque)


class Drive:
    """Torque (n,) [Nm] of n drives, from set point and true position and velocity."""

    def __init__(self, robot, difficulty):
        self._rigid_torque = robot.rigid_torque
        self._rotor = by_size(difficulty.rotor_inertia, robot.file.max_torque)
        self._limit = np.array(robot.file.max_torque)
        self._gain = VELOCITY_BANDWIDTH * _tuning_inertia(robot, difficulty)
        self._integral = np.zeros(robot.n)
        self._error, self._raw, self.torque = np.zeros((3, robot.n))

    def balance(self, setpoint, torque):
        """Start in equilibrium: the integrator holds what torque (n,) needs beside the model."""
        self.torque[:] = np.clip(torque, -self._limit, self._limit)
        self._integral[:] = self.torque - self._rigid_torque(*setpoint)

    def step(self, setpoint, position, velocity, dt):
        """Return the torque (n,) for a set point (3, n), limited to the drives' peak."""
        q, v, a = setpoint
        error, raw, torque = self._error, self._raw, self.torque
        np.subtract(q, position, out=error)
        error *= POSITION_GAIN
        error += v
        error -= velocity
        error *= self._gain
        np.multiply(self._rotor, a, out=raw)
        raw += self._rigid_torque(q, v, a)
        raw += error
        raw += self._integral
        np.minimum(raw, self._limit, out=torque)
        np.maximum(torque, -self._limit, out=torque)
        # A saturated drive's integrator stands still, or it would overshoot afterwards.
        error *= INTEGRAL_RATE * dt
        error *= raw == torque
        self._integral += error
        return torque
