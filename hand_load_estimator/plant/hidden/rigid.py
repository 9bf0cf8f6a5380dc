"""Rigid-body effects: a link that is heavier, a rotor that is, a base that leans."""

import numpy as np

from ..arm import Arm
from .effect import HiddenEffect, Parameter


class LinkInertia(HiddenEffect):
    """
    Something bolted to a link that the robot file does not know: a point mass on it.

    One mass per listed joint's link; a strength sets them all in the same proportion.
    """

    name, amplitude = 'link_inertia', 'mass'
    parameters = {'mass': Parameter('kg', 0.0), 'x': Parameter('m'), 'y': Parameter('m'),
                  'z': Parameter('m')}
    shared = True

    def draw(self, rng, truth, motion):
        """Return a place near each link's centre of mass."""
        com = np.array([link[:3, 3] / max(link[3, 3], 1e-9) for link in truth.links])
        com = com + rng.uniform(-0.08, 0.08, com.shape)
        return dict(zip('xyz', com.T))

    def _pseudo(self, p, j):
        point = np.array([p['x'][j], p['y'][j], p['z'][j], 1.0])
        return p['mass'][j] * np.outer(point, point)

    def torque_along(self, motion, truth, p):
        """Return the torque of the extra masses by the link regressor."""
        pseudo = [self._pseudo(p, j) for j in range(motion.robot.n)]
        products = np.concatenate([_products(part) for part in pseudo])
        return np.array([motion.robot.link_regressor(*row) @ products
                         for row in zip(motion.q, motion.v, motion.a)])

    def apply(self, truth, p):
        """Add the masses to the links."""
        truth.links = [link + self._pseudo(p, j) for j, link in enumerate(truth.links)]


def _products(pseudo):
    """Return the (10,) products of a pseudo-inertia in pinocchio's order."""
    tensor = np.trace(pseudo[:3, :3]) * np.eye(3) - pseudo[:3, :3]
    return np.array([pseudo[3, 3], *pseudo[:3, 3], tensor[0, 0], tensor[0, 1], tensor[1, 1],
                     tensor[0, 2], tensor[1, 2], tensor[2, 2]])


class RotorInertia(HiddenEffect):
    """More inertia on the rotor's side of the gear."""

    name, amplitude = 'rotor_inertia', 'inertia'
    parameters = {'inertia': Parameter('kg m^2', 0.0)}

    def torque_along(self, motion, truth, p):
        """Return inertia x acceleration."""
        return p['inertia'] * motion.a

    def apply(self, truth, p):
        """Add to the rotors."""
        truth.rotor = truth.rotor + p['inertia']


class BaseTilt(HiddenEffect):
    """A base that is not mounted as the robot file says: one small rotation of gravity."""

    name, amplitude = 'base_tilt', 'angle'
    parameters = {'angle': Parameter('rad', 0.0, 1.6),
                  'direction': Parameter('rad')}
    per_joint, shared, linear = False, True, False

    def draw(self, rng, truth, motion):
        """Return the direction of the tilt about the vertical."""
        return {'direction': rng.uniform(-np.pi, np.pi)}

    def bounds(self, truth):
        """Return up to half a radian."""
        return 1e-5, 0.5

    def _tilted(self, gravity, p):
        down = gravity / np.linalg.norm(gravity)
        across = np.cross(down, [1.0, 0.0, 0.0] if abs(down[0]) < 0.7 else [0.0, 1.0, 0.0])
        across /= np.linalg.norm(across)
        axis = (np.cos(p['direction']) * across
                + np.sin(p['direction']) * np.cross(down, across))
        return gravity * np.cos(p['angle']) + np.cross(axis, gravity) * np.sin(p['angle'])

    def torque_along(self, motion, truth, p):
        """Return the gravity torque of the difference in gravity."""
        difference = self._tilted(truth.gravity, p) - truth.gravity
        arm = Arm(motion.robot, truth.links, truth.rotor, difference)
        out = np.empty_like(motion.q)
        for k, q in enumerate(motion.q):
            arm.position[:] = q
            out[k] = arm.hold_torque()
        return out

    def apply(self, truth, p):
        """Turn gravity."""
        truth.gravity = self._tilted(truth.gravity, p)
