"""Viscous friction that changes with temperature."""

from .effect import Effect, side_by_side


def _columns(x, j, _):
    warmth = x.warmth[:, j]
    linear = x.v[:, j] * warmth
    return side_by_side(linear, linear * warmth)


TEMPERATURE_DEPENDENT_VISCOUS_FRICTION = Effect(
    'temperature_dependent_viscous_friction', 'viscous friction falls as the grease warms',
    'Bittencourt and Axelsson 2014 (their exponential to second order); E5.2',
    (('slope', 'Nm s/(rad K)'), ('curvature', 'Nm s/(rad K^2)')), (2e-3, 5e-5), _columns,
    against='temperature', default=True, needs=frozenset({'warmth'}))
