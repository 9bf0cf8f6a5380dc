"""The motion along which the strength of hidden effects is stated."""

import numpy as np

from ..friction import friction_along

DURATION = 10.0         # [s]
WARMER = 15.0           # [K] above the robot file's reference temperature
_STEP = 2e-3            # [s]
_SHARE = 0.6            # of velocity and acceleration limits
_SWING = 1.2            # [rad] largest distance from the middle
_FREQUENCIES = (0.1, 0.2, 0.3, 0.4, 0.5)  # [Hz]


class ReferenceMotion:
    """
    Ten seconds of multi-sine with 60 % of the velocity and acceleration limits, without load.

    The same for every plant of a robot. time (N,); q, v, a, rigid (nominal torque behind the
    gear), friction, motor = all that the drives supply, (N, n). Temperature (n,) is the reference
    temperature; effects of temperature are stated WARMER degrees above it. arm: the true Arm.
    """

    def __init__(self, robot, truth, arm):
        self.dt, self.arm, self.robot = _STEP, arm, robot
        self.time = np.arange(0.0, DURATION, _STEP)
        self.q, self.v, self.a = _multi_sine(robot, self.time)
        self.rigid = np.array([robot.rigid_torque(*row) for row in zip(self.q, self.v, self.a)])
        temperature = np.full(robot.n, robot.file.reference_temperature)
        self.friction = friction_along(truth.friction, self.v, self.rigid, temperature, _STEP)
        self.motor = self.rigid + truth.rotor * self.a + self.friction
        self.temperature = temperature

    def hands(self):
        """Return positions (N, 3), rotations (N, 3, 3) and Jacobians (N, 3, n) of the hand."""
        places, rotations, jacobians = [], [], []
        for q in self.q:
            self.arm.position[:] = q
            place, rotation, jacobian = self.arm.hand()
            places.append(place.copy())
            rotations.append(rotation.copy())
            jacobians.append(jacobian.copy())
        return np.array(places), np.array(rotations), np.array(jacobians)


def _multi_sine(robot, time):
    rng = np.random.default_rng(2026)
    limits, n = robot.limits, robot.n
    low, high = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
    middle = np.where((low < -0.5) & (high > 0.5), 0.0, 0.5 * (low + high))
    omega = 2.0 * np.pi * np.array(_FREQUENCIES)[:, None]
    weight = rng.uniform(0.3, 1.0, (len(_FREQUENCIES), n)) / omega
    phase = rng.uniform(0.0, 2.0 * np.pi, (len(_FREQUENCIES), n))
    angle = omega[:, None] * time[:, None] + phase[:, None]
    q = np.einsum('kn,ktn->tn', weight, np.sin(angle))
    v = np.einsum('kn,ktn->tn', weight * omega, np.cos(angle))
    a = np.einsum('kn,ktn->tn', -weight * omega ** 2, np.sin(angle))
    room = np.minimum(_SWING, 0.9 * np.minimum(high - middle, middle - low))
    scale = np.min([_SHARE * limits.velocity / np.max(np.abs(v), axis=0),
                    _SHARE * limits.acceleration / np.max(np.abs(a), axis=0),
                    room / np.max(np.abs(q), axis=0)], axis=0)
    return middle + scale * q, scale * v, scale * a
