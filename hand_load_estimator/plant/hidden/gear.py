"""Backlash: the gear's torque is gone while the link crosses the gap between the teeth."""

import numpy as np

from .effect import HiddenEffect, Parameter

_RINGING = 0.01  # [s] over which the teeth take up the link's momentum
# [s] over which the link's load is averaged. The motor alone is lighter than motor and link, and
# a drive tuned for both would fight its own reaction from one step to the next.
_AVERAGE = 0.02


class Backlash(HiddenEffect):
    """
    A gap in the gear. When its torque changes sign the link crosses it, driven by its own load.

    The motor carries nothing meanwhile and takes the link's momentum when the teeth meet. The
    encoder is on the motor's side and sees nothing of the gap.
    """

    name, amplitude = 'backlash', 'gap'
    parameters = {'gap': Parameter('rad', 0.0, 0.05), 'inertia': Parameter('kg m^2', 1e-6)}
    linear = False

    def draw(self, rng, truth, motion):
        """Return the link's inertia about its joint, mean over the motion."""
        poses = motion.q[:: len(motion.q) // 20]
        return {'inertia': np.mean([np.diag(motion.robot.mass_matrix(q)) for q in poses],
                                   axis=0)}

    def bounds(self, truth):
        """Return gaps from microradians to a gear nobody would still use."""
        return np.full(len(truth.rotor), 1e-6), np.full(len(truth.rotor), 0.05)

    def torque_along(self, motion, truth, p):
        """Return the torque along the motion, which changes sign where gravity does."""
        gap = Gap(p)
        return np.array([gap.cross(tau, motion.dt).copy() for tau in motion.rigid])

    def apply(self, truth, p):
        """Put the gap into the gears."""
        truth.joint_torques.append(Gap(p))


class Gap:
    """Where the link is in the gap (n,) [rad], per joint; joints without one feel nothing."""

    def __init__(self, p):
        self.gap, self._inertia = p['gap'], p['inertia']
        self._half, n = 0.5 * self.gap, len(self.gap)
        self._place, self._speed, self._pulse, self._torque = np.zeros((4, n))
        self._load, self._apart = None, np.zeros(n, dtype=bool)

    def torque(self, now, dt):
        """Return the torque (n,) the drives see, from the torque the gears carried last."""
        return self.cross(now.gear_torque - self._torque, dt)

    def cross(self, link_torque, dt):
        """Return the torque (n,) for the torque the link needs (n,) [Nm]."""
        if self._load is None:
            # At the start the teeth are together on the side the load pushes to.
            self._load = np.array(link_torque)
            self._place = -self._half * np.sign(link_torque)
        self._load = self._load + min(dt / _AVERAGE, 1.0) * (link_torque - self._load)
        self._speed = self._speed - dt * self._load / self._inertia
        place = self._place + dt * self._speed
        met = np.abs(place) >= self._half
        self._place = np.clip(place, -self._half, self._half)
        impulse = np.where(met & self._apart, self._inertia * self._speed, 0.0)
        self._pulse = self._pulse * np.exp(-dt / _RINGING) + impulse / _RINGING
        self._speed = np.where(met, 0.0, self._speed)
        self._apart = ~met
        self._torque = np.where(met, 0.0, -self._load) - self._pulse
        return self._torque
