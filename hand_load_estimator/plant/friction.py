"""
Joint friction: Bittencourt and Axelsson's static curve behind an elastoplastic bristle.

The static curve (doi 10.1115/1.4027221) gives the level friction slides at; Dupont's elastoplastic
bristle (2002) is the state that gets there: within `elastic` of the breakaway deflection it is a
spring, so a joint at rest stays where it is (no drift), and it slides fully after a milliradian
or two.
"""

from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from .difficulty import by_size

REFERENCE = 25.0  # [degC] at which the figures are stated
ELASTIC = 0.3     # [-] of the breakaway deflection, below which the bristle does not creep
# Travel after a reversal, in breakaway deflections, until 95 % of the sliding level is reached;
# follows from ELASTIC and the shape of the transition (test_plant_friction holds it).
REVERSAL = 2.85
# What a joint at rest holds is drawn evenly up to this share of its breakaway level, either way.
START = 0.95


@dataclass
class FrictionFigures:
    """
    Friction of n joints, (n,) each, at the reference temperature where it depends on it.

    coulomb [Nm], coulomb_slope [Nm/K], asymmetry [Nm] (added forwards, taken off backwards);
    static [Nm] above Coulomb; stribeck_velocity [rad/s], stribeck_rise [rad/s/K],
    stribeck_exponent; viscous_rest [Nm s/rad] that stays when hot, viscous_part [Nm s/rad] that
    falls as exp(-(T - 25)/viscous_range), viscous_slope [Nm s/rad/K] from hidden effects;
    load_share [-] of the gear's torque; presliding [rad] travel from one sliding level to the
    other; stiffness [Nm/rad] of the bristles.
    """

    coulomb: np.ndarray
    coulomb_slope: np.ndarray
    asymmetry: np.ndarray
    static: np.ndarray
    stribeck_velocity: np.ndarray
    stribeck_rise: np.ndarray
    stribeck_exponent: np.ndarray
    viscous_rest: np.ndarray
    viscous_part: np.ndarray
    viscous_range: np.ndarray
    viscous_slope: np.ndarray
    load_share: np.ndarray
    presliding: np.ndarray

    @property
    def stiffness(self):
        """Bristle stiffness (n,) [Nm/rad]; never zero, so that no friction is no division."""
        return (self.coulomb + self.static + 1e-9) * REVERSAL / self.presliding

    def at(self, temperature):
        """Return Coulomb (n,), Stribeck velocity (n,), viscous (n,) at temperature (n,)."""
        warmer = temperature - REFERENCE
        coulomb = np.maximum(self.coulomb + self.coulomb_slope * warmer, 0.1 * self.coulomb)
        velocity = np.maximum(self.stribeck_velocity + self.stribeck_rise * warmer, 5e-3)
        viscous = (self.viscous_rest + self.viscous_slope * warmer
                   + self.viscous_part * np.exp(-warmer / self.viscous_range))
        floor = 0.1 * (self.viscous_rest + self.viscous_part)
        return coulomb, velocity, np.maximum(viscous, floor)


def draw_friction(robot, difficulty, rng):
    """Return the FrictionFigures of one plant."""
    n, max_torque = robot.n, robot.file.max_torque

    def spread(width):
        return rng.uniform(1.0 - width, 1.0 + width, n)

    def pair(limits):
        return rng.uniform(*limits, n)

    coulomb = by_size(difficulty.coulomb, max_torque) * spread(difficulty.friction_spread)
    viscous = by_size(difficulty.viscous, max_torque) * spread(difficulty.friction_spread)
    fall_range = pair(difficulty.viscous_fall_range)
    falling = np.minimum(pair(difficulty.viscous_fall) * fall_range, 0.9)
    return FrictionFigures(
        coulomb=coulomb, coulomb_slope=-coulomb * pair(difficulty.coulomb_fall),
        asymmetry=coulomb * difficulty.asymmetry * rng.uniform(-1.0, 1.0, n),
        static=coulomb * pair(difficulty.stribeck),
        stribeck_velocity=pair(difficulty.stribeck_velocity),
        stribeck_rise=pair(difficulty.stribeck_velocity_rise),
        stribeck_exponent=pair(difficulty.stribeck_exponent),
        viscous_rest=viscous * (1.0 - falling), viscous_part=viscous * falling,
        viscous_range=fall_range, viscous_slope=np.zeros(n), load_share=np.zeros(n),
        presliding=pair(difficulty.presliding))


class Friction:
    """
    The bristles of n joints, one state each.

    `torque` (n,) [Nm] opposes motion: the drive has to supply it. start_std (n,) [Nm]: standard
    deviation of what it is at the start. Stable for any step: the deflection never passes the
    breakaway level, however far a joint moves in one step.
    """

    def __init__(self, figures, temperature, gear_torque, rng):
        n = len(figures.coulomb)
        self._figures, self._compliance = figures, 1.0 / figures.stiffness
        self._stiffness = figures.stiffness
        self._has_load_share = bool(np.any(figures.load_share))
        self.torque = np.zeros(n)
        self._sign, self._speed, self._level, self._work, self._creep = np.zeros((5, n))
        self.set_temperature(temperature)
        self._breakaway(np.zeros(n), gear_torque)
        # A joint at rest holds whatever its last motion left in the bristles.
        self._deflection = self._level * rng.uniform(-START, START, n)
        self.start_std = START / np.sqrt(3.0) * self._stiffness * self._level
        np.multiply(self._stiffness, self._deflection, out=self.torque)

    def shifted(self, torque):
        """Return a copy whose bristles hold a torque (n,) [Nm] more."""
        other = deepcopy(self)
        other._deflection += torque * self._compliance
        other.torque += torque
        return other

    def set_temperature(self, temperature):
        """Take the figures at gear temperature (n,) [degC]."""
        self._coulomb, velocity, self._viscous = self._figures.at(temperature)
        self._per_stribeck = 1.0 / velocity

    def _breakaway(self, velocity, gear_torque):
        """Write the deflection (n,) [rad] at which the bristles slide into self._level."""
        level, work, figures = self._level, self._work, self._figures
        np.sign(velocity, out=self._sign)
        np.abs(velocity, out=self._speed)
        np.multiply(self._speed, self._per_stribeck, out=level)
        np.power(level, figures.stribeck_exponent, out=level)
        np.negative(level, out=level)
        np.exp(level, out=level)
        level *= figures.static
        level += self._coulomb
        np.multiply(figures.asymmetry, self._sign, out=work)
        level += work
        if self._has_load_share:
            np.abs(gear_torque, out=work)
            work *= figures.load_share
            level += work
        level *= self._compliance
        np.maximum(level, 1e-12, out=level)

    def step(self, velocity, gear_torque, dt):
        """Move the bristles by velocity (n,) x dt and return the friction torque (n,)."""
        self._breakaway(velocity, gear_torque)
        z, level, work, creep = self._deflection, self._level, self._work, self._creep
        np.divide(z, level, out=work)
        work *= self._sign
        # Smooth step from elastic (creep 0) to sliding (creep 1) of the aligned deflection.
        np.subtract(work, ELASTIC, out=creep)
        creep *= 1.0 / (1.0 - ELASTIC)
        np.maximum(creep, 0.0, out=creep)
        np.minimum(creep, 1.0, out=creep)
        work *= creep
        work *= creep
        creep *= -2.0
        creep += 3.0
        work *= creep
        np.subtract(1.0, work, out=work)
        work *= velocity
        work *= dt
        z += work
        # Only the way it slides: what is held against the motion unloads like a spring, even
        # where this direction's level is below it.
        np.multiply(z, self._sign, out=work)
        np.minimum(work, level, out=work)
        work *= self._sign
        np.copyto(z, work, where=self._sign != 0.0)
        np.multiply(self._stiffness, z, out=self.torque)
        np.multiply(self._viscous, velocity, out=work)
        self.torque += work
        return self.torque


def friction_along(figures, velocity, gear_torque, temperature, dt):
    """Return the friction torque (N, n) of bristles led along velocity (N, n) in steps of dt."""
    # The start is drawn, but the same for every call: differences of two calls are free of it.
    bristles = Friction(figures, temperature, gear_torque[0], np.random.default_rng(0))
    return np.array([bristles.step(v, tau, dt).copy() for v, tau in zip(velocity, gear_torque)])
