"""Viscous friction that changes with temperature."""

import numpy as np

from .effect import Effect


def _columns(x, j, _):
    v, warmth = x.v[:, j], x.warmth[:, j]
    return np.stack([v * warmth, v * warmth ** 2], axis=-1)


TEMPERATURE_DEPENDENT_VISCOUS_FRICTION = Effect(
    'temperature_dependent_viscous_friction', 'viscous friction falls as the grease warms',
    'Bittencourt and Axelsson 2014 (their exponential to second order); E5.2',
    (('slope', 'Nm s/(rad K)'), ('curvature', 'Nm s/(rad K^2)')), (2e-3, 5e-5), _columns,
    against='temperature', default=True, needs=frozenset({'warmth'}))
