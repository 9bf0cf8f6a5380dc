"""More friction than the default plant has, or friction of another kind."""

from dataclasses import replace

import numpy as np

from ..friction import friction_along
from .effect import FunctionTorque, HiddenEffect, Parameter
from .reference_motion import WARMER

_HELD_BACK = 0.8  # share of a friction that warming by WARMER may take away
_REVERSAL_SPEED = 0.01  # [rad/s] width of a sign that must not chatter


class CoulombFriction(HiddenEffect):
    """More Coulomb friction."""

    name, amplitude = 'coulomb_friction', 'torque'
    parameters = {'torque': Parameter('Nm', 0.0)}

    def torque_along(self, motion, truth, p):
        """Return torque x sign of velocity."""
        return p['torque'] * np.sign(motion.v)

    def apply(self, truth, p):
        """Add to the sliding level."""
        truth.friction.coulomb = truth.friction.coulomb + p['torque']


class ViscousFriction(HiddenEffect):
    """More viscous friction, not falling with temperature."""

    name, amplitude = 'viscous_friction', 'coefficient'
    parameters = {'coefficient': Parameter('Nm s/rad', 0.0)}

    def torque_along(self, motion, truth, p):
        """Return coefficient x velocity."""
        return p['coefficient'] * motion.v

    def apply(self, truth, p):
        """Add to what stays when hot."""
        truth.friction.viscous_rest = truth.friction.viscous_rest + p['coefficient']


class FrictionAsymmetry(HiddenEffect):
    """Coulomb friction higher forwards by a torque and lower backwards by the same."""

    name, amplitude = 'friction_asymmetry', 'torque'
    parameters = {'torque': Parameter('Nm')}

    def bounds(self, truth):
        """Return up to where backwards friction would be nearly gone."""
        return 1e-9, _HELD_BACK * truth.friction.coulomb

    def torque_along(self, motion, truth, p):
        """Return the torque wherever the joint moves."""
        return p['torque'] * (motion.v != 0.0)

    def apply(self, truth, p):
        """Add to the asymmetry."""
        truth.friction.asymmetry = truth.friction.asymmetry + p['torque']


class StribeckFriction(HiddenEffect):
    """More static friction, gone at the joint's Stribeck velocity."""

    name, amplitude = 'stribeck_friction', 'torque'
    parameters = {'torque': Parameter('Nm', 0.0)}
    linear = False

    def bounds(self, truth):
        """Return up to ten times Coulomb friction."""
        return 1e-3 * truth.friction.coulomb, 10.0 * truth.friction.coulomb

    def torque_along(self, motion, truth, p):
        """Return friction with the higher peak less friction with the default's."""
        static = truth.friction.static + p['torque']
        return _with(truth, motion, static=static) - motion.friction

    def apply(self, truth, p):
        """Add to the static friction."""
        truth.friction.static = truth.friction.static + p['torque']


class LoadDependentFriction(HiddenEffect):
    """Friction growing with the torque through the gear."""

    name, amplitude = 'load_dependent_friction', 'share'
    parameters = {'share': Parameter('-', 0.0, 0.9)}

    def bounds(self, truth):
        """Return up to a gear that nearly blocks itself."""
        return 1e-9, 0.9

    def torque_along(self, motion, truth, p):
        """Return share x gear torque against the motion."""
        return p['share'] * np.abs(motion.rigid) * np.sign(motion.v)

    def apply(self, truth, p):
        """Set the share."""
        truth.friction.load_share = truth.friction.load_share + p['share']


class TemperatureDependentCoulomb(HiddenEffect):
    """Coulomb friction falling faster with temperature."""

    name, amplitude = 'temperature_dependent_coulomb_friction', 'fall'
    parameters = {'fall': Parameter('Nm/K', 0.0)}

    def bounds(self, truth):
        """Return up to where warming takes nearly all of it."""
        return 1e-9, _HELD_BACK * truth.friction.coulomb / WARMER

    def torque_along(self, motion, truth, p):
        """Return the change at WARMER degrees above the reference."""
        return -p['fall'] * WARMER * np.sign(motion.v)

    def apply(self, truth, p):
        """Add to the slope."""
        truth.friction.coulomb_slope = truth.friction.coulomb_slope - p['fall']


class TemperatureDependentViscous(HiddenEffect):
    """Viscous friction falling faster with temperature."""

    name, amplitude = 'temperature_dependent_viscous_friction', 'fall'
    parameters = {'fall': Parameter('Nm s/rad/K', 0.0)}

    def bounds(self, truth):
        """Return up to where warming, with the base's own fall, takes nearly all of it."""
        friction = truth.friction
        left = (friction.viscous_rest
                + friction.viscous_part * np.exp(-WARMER / friction.viscous_range))
        return 1e-9, _HELD_BACK * left / WARMER

    def torque_along(self, motion, truth, p):
        """Return the change at WARMER degrees above the reference."""
        return -p['fall'] * WARMER * motion.v

    def apply(self, truth, p):
        """Add to the slope."""
        truth.friction.viscous_slope = truth.friction.viscous_slope - p['fall']


class PreslidingHysteresis(HiddenEffect):
    """Presliding over a longer travel: friction turns slowly after a reversal."""

    name, amplitude = 'presliding_hysteresis', 'distance'
    parameters = {'distance': Parameter('rad', 1e-5, 1.0)}
    linear = False

    def bounds(self, truth):
        """Return from the default's to a travel longer than most motions."""
        return 1.001 * truth.friction.presliding, np.full(len(truth.rotor), 1.0)

    def torque_along(self, motion, truth, p):
        """Return friction with the longer travel less friction with the default's."""
        longer = np.where(p['distance'] > 0.0, p['distance'], truth.friction.presliding)
        return _with(truth, motion, presliding=longer) - motion.friction

    def apply(self, truth, p):
        """Replace the travel of the listed joints."""
        friction = truth.friction
        friction.presliding = np.where(p['distance'] > 0.0, p['distance'], friction.presliding)


def _with(truth, motion, **figures):
    """Return the friction (N, n) along the motion of a truth with other figures."""
    return friction_along(replace(truth.friction, **figures), motion.v, motion.rigid,
                          motion.temperature, motion.dt)


class ShearThinningFriction(FunctionTorque):
    """Friction of a power-law fluid: `torque` at 1 rad/s, growing with a power of speed."""

    name, amplitude, variable = 'shear_thinning_friction', 'torque', 'velocity'
    parameters = {'torque': Parameter('Nm', 0.0), 'exponent': Parameter('-', 0.1, 1.0)}

    def draw(self, rng, truth, motion):
        """Return exponents between nearly dry and nearly viscous friction."""
        return {'exponent': rng.uniform(0.3, 0.7, motion.robot.n)}

    @staticmethod
    def of(v, p):
        """Return the torque at velocity v; a fluid at rest is a fluid, with a finite viscosity."""
        return p['torque'] * v * (v * v + _REVERSAL_SPEED ** 2) ** (0.5 * (p['exponent'] - 1.0))


class SpeedResonanceFriction(FunctionTorque):
    """Friction with a resonance in speed: a peak of a width at one speed, in no vocabulary."""

    name, amplitude, variable = 'speed_resonance_friction', 'torque', 'velocity'
    parameters = {'torque': Parameter('Nm', 0.0), 'speed': Parameter('rad/s', 1e-3),
                  'width': Parameter('rad/s', 1e-3)}

    def draw(self, rng, truth, motion):
        """Return a speed the motion reaches, and a width."""
        speed = rng.uniform(0.3, 0.7, motion.robot.n) * np.max(np.abs(motion.v), axis=0)
        return {'speed': speed, 'width': 0.2 * speed}

    @staticmethod
    def of(v, p):
        """Return the torque at velocity v."""
        off = (np.abs(v) - p['speed']) / p['width']
        return p['torque'] * np.tanh(v / _REVERSAL_SPEED) / (1.0 + off * off)
