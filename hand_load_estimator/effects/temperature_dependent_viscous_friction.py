"""Viscous friction that changes with temperature, up to where it levels off."""

from .effect import Effect, side_by_side
from .knee import KNEE, falling_warmth


def _columns(x, j, shape):
    warmth = falling_warmth(x, j, shape)
    linear = x.v[:, j] * warmth
    return side_by_side(linear, linear * warmth)


TEMPERATURE_DEPENDENT_VISCOUS_FRICTION = Effect(
    'temperature_dependent_viscous_friction',
    'viscous friction falls as the grease warms, up to a knee',
    'Bittencourt and Axelsson 2014 (their exponential to second order); E5.2; Muggeo 2003',
    (('slope', 'Nm s/(rad K)'), ('curvature', 'Nm s/(rad K^2)')), (2e-3, 5e-5), _columns, (KNEE,),
    against='temperature', default=True, needs=frozenset({'warmth'}))
