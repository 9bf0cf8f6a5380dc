"""Coulomb friction that changes with temperature, up to where it levels off."""

from .effect import Effect
from .knee import KNEE, falling_warmth


def _columns(x, j, shape):
    # As all friction it turns over the presliding travel, not with the sign of the velocity.
    return (x.z[:, j] * falling_warmth(x, j, shape))[..., None]


TEMPERATURE_DEPENDENT_COULOMB_FRICTION = Effect(
    'temperature_dependent_coulomb_friction',
    'Coulomb friction changes with temperature, up to a knee', 'E5.2; Muggeo 2003',
    (('slope', 'Nm/K'),), (5e-4,), _columns, (KNEE,), against='temperature', default=True,
    needs=frozenset({'warmth'}))
