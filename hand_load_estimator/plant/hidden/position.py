"""Torques that depend on joint position: balancer, cables, gear ripple."""

import numpy as np

from .effect import FunctionTorque, Parameter


class GravitySpring(FunctionTorque):
    """A balancer: stiffness x sin(q - angle), one period per turn."""

    name, amplitude = 'gravity_spring', 'stiffness'
    parameters = {'stiffness': Parameter('Nm'), 'angle': Parameter('rad')}

    def draw(self, rng, truth, motion):
        """Return the angle of rest."""
        return {'angle': rng.uniform(-np.pi, np.pi, motion.robot.n)}

    @staticmethod
    def of(q, p):
        """Return the torque at position q."""
        return p['stiffness'] * np.sin(q - p['angle'])


class CableDrag(FunctionTorque):
    """A cable bundle that is pulled tight to one side: smooth and not periodic."""

    name, amplitude = 'cable_drag', 'torque'
    parameters = {'torque': Parameter('Nm'), 'centre': Parameter('rad')}

    def draw(self, rng, truth, motion):
        """Return where the bundle hangs free, near the middle of the motion."""
        return {'centre': motion.q.mean(axis=0) + rng.uniform(-0.5, 0.5, motion.robot.n)}

    @staticmethod
    def of(q, p):
        """Return the torque at position q."""
        x = q - p['centre']
        return p['torque'] * (x / (1.0 + 0.3 * np.abs(x)) + 0.4 * x * x / (1.0 + 0.3 * x * x))


class TorqueRipple(FunctionTorque):
    """Gear and magnet ripple: a sine of many periods per turn and its second harmonic."""

    name, amplitude = 'torque_ripple', 'torque'
    parameters = {'torque': Parameter('Nm'), 'periods': Parameter('per turn', 2.0, 1000.0),
                  'phase': Parameter('rad'), 'second_phase': Parameter('rad')}

    def draw(self, rng, truth, motion):
        """Return whole periods per turn and phases."""
        n = motion.robot.n
        return {'periods': rng.integers(50, 111, n).astype(float),
                'phase': rng.uniform(-np.pi, np.pi, n),
                'second_phase': rng.uniform(-np.pi, np.pi, n)}

    @staticmethod
    def of(q, p):
        """Return the torque at position q."""
        angle = p['periods'] * q
        return p['torque'] * (np.sin(angle + p['phase'])
                              + 0.4 * np.sin(2.0 * angle + p['second_phase']))
