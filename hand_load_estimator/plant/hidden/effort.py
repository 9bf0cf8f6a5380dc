"""Errors of the reported effort: gain, its change with temperature, soft end, offset, delay."""

import numpy as np

from ..sensors import saturated
from .effect import HiddenEffect, Parameter
from .reference_motion import WARMER


class TorqueScale(HiddenEffect):
    """A torque constant that is wrong: effort too large by a factor 1 + gain."""

    name, amplitude = 'torque_scale', 'gain'
    parameters = {'gain': Parameter('-', -0.9, 10.0)}

    def torque_along(self, motion, truth, p):
        """Return gain x torque."""
        return p['gain'] * motion.motor

    def apply(self, truth, p):
        """Scale the effort."""
        truth.effort_gain = truth.effort_gain * (1.0 + p['gain'])


class TorqueScaleTemperature(HiddenEffect):
    """A torque constant that changes with temperature (magnets lose 0.1 %/K when warm)."""

    name, amplitude = 'torque_scale_temperature', 'slope'
    parameters = {'slope': Parameter('1/K', -0.1, 0.1)}

    def torque_along(self, motion, truth, p):
        """Return the change at WARMER degrees above the reference."""
        return p['slope'] * WARMER * motion.motor

    def apply(self, truth, p):
        """Add to the gain's slope."""
        truth.effort_gain_slope = truth.effort_gain_slope + p['slope']


class TorqueOffset(HiddenEffect):
    """A constant added to the effort."""

    name, amplitude = 'torque_offset', 'torque'
    parameters = {'torque': Parameter('Nm')}

    def torque_along(self, motion, truth, p):
        """Return the constant."""
        return p['torque'] * np.ones_like(motion.v)

    def apply(self, truth, p):
        """Add to the offset."""
        truth.effort_offset = truth.effort_offset + p['torque']


class TimeDelay(HiddenEffect):
    """Effort that belongs to an earlier moment than the position beside it."""

    name, amplitude = 'time_delay', 'delay'
    parameters = {'delay': Parameter('s', 0.0, 0.5)}
    linear = False

    def bounds(self, truth):
        """Return delays up to a tenth of a second."""
        return np.full(len(truth.rotor), 1e-5), np.full(len(truth.rotor), 0.1)

    def torque_along(self, motion, truth, p):
        """Return torque a delay ago less torque now."""
        columns = [np.interp(motion.time - delay, motion.time, column)
                   for delay, column in zip(p['delay'], motion.motor.T)]
        return np.array(columns).T - motion.motor

    def apply(self, truth, p):
        """Add to the delay."""
        truth.effort_delay = truth.effort_delay + p['delay']


class SaturatingDrive(HiddenEffect):
    """Effort that falls behind the torque as that grows, to end at 1 / bend: in no vocabulary."""

    name, amplitude = 'saturating_drive', 'bend'
    parameters = {'bend': Parameter('1/Nm', 0.0)}
    linear = False

    def bounds(self, truth):
        """Return ends far beyond any torque, and as near as the noise is large."""
        return 1e-5 / truth.noise, 1.0 / truth.noise

    def torque_along(self, motion, truth, p):
        """Return what is reported less the torque."""
        return saturated(motion.motor, p['bend']) - motion.motor

    def apply(self, truth, p):
        """Add to the bend."""
        truth.effort_bend = truth.effort_bend + p['bend']
