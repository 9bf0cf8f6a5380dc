"""Friction of a joint as a function of its velocity, temperature and path."""

import numpy as np

from .effect import Effect, Shape

# The sign of a measured velocity is taken over this width [rad/s], a few times its noise.
SIGN_WIDTH = 0.01


def sign_of(v):
    """Return the smoothed sign of velocities [rad/s]."""
    return np.tanh(v / SIGN_WIDTH)


def _coulomb(x, j, _):
    return sign_of(x.v[:, j])[..., None]


def _viscous(x, j, _):
    return x.v[:, j][..., None]


def _asymmetry(x, j, _):
    return np.abs(x.v[:, j])[..., None]


def _stribeck(x, j, shape):
    v = x.v[:, j]
    bump = sign_of(v) * np.exp(-np.abs(v) / shape['stribeck_velocity'])
    return np.stack([bump, bump * x.warmth[:, j]], axis=-1)


def _presliding(x, j, _):
    return (x.z[:, j] - sign_of(x.v[:, j]))[..., None]


def _viscous_temperature(x, j, _):
    v, warmth = x.v[:, j], x.warmth[:, j]
    return np.stack([v * warmth, v * warmth ** 2], axis=-1)


def _coulomb_temperature(x, j, _):
    return (sign_of(x.v[:, j]) * x.warmth[:, j])[..., None]


COULOMB = Effect(
    'coulomb_friction', 'constant against the motion', 'Coulomb 1785',
    (('level', 'Nm'),), (0.1,), _coulomb)
VISCOUS = Effect(
    'viscous_friction', 'in proportion to velocity', 'Armstrong-Helouvry et al. 1994',
    (('coefficient', 'Nm s/rad'),), (0.1,), _viscous)
ASYMMETRY = Effect(
    'friction_asymmetry', 'viscous friction differs between the directions',
    'Armstrong-Helouvry et al. 1994', (('coefficient', 'Nm s/rad'),), (0.01,), _asymmetry)
STRIBECK = Effect(
    'stribeck_friction', 'falls from breakaway to Coulomb as lubrication builds up',
    'Bittencourt and Axelsson 2014', (('level', 'Nm'), ('slope', 'Nm/K')), (0.05, 1e-3),
    _stribeck,
    (Shape('stribeck_velocity', 'rad/s', 0.1, (0.03, 0.06, 0.12, 0.25, 0.5)),))
PRESLIDING = Effect(
    'presliding_hysteresis', 'friction turns over a short travel after a reversal', 'Dahl 1968',
    (('level', 'Nm'),), (0.1,), _presliding,
    (Shape('presliding_distance', 'rad', 1e-3, (2e-4, 4e-4, 7e-4, 1e-3, 1.5e-3, 2.5e-3, 5e-3)),))
VISCOUS_TEMPERATURE = Effect(
    'temperature_dependent_viscous_friction', 'viscous friction falls as the grease warms',
    'Bittencourt and Axelsson 2014 (their exponential to second order); E5.2',
    (('slope', 'Nm s/(rad K)'), ('curvature', 'Nm s/(rad K^2)')), (2e-3, 5e-5),
    _viscous_temperature)
COULOMB_TEMPERATURE = Effect(
    'temperature_dependent_coulomb_friction', 'Coulomb friction changes with temperature',
    'E5.2', (('slope', 'Nm/K'),), (5e-4,), _coulomb_temperature)
