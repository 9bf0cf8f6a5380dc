"""Coulomb friction that changes with temperature."""

from .effect import Effect


def _columns(x, j, _):
    return (x.sign[:, j] * x.warmth[:, j])[..., None]


TEMPERATURE_DEPENDENT_COULOMB_FRICTION = Effect(
    'temperature_dependent_coulomb_friction', 'Coulomb friction changes with temperature',
    'E5.2', (('slope', 'Nm/K'),), (5e-4,), _columns, against='temperature', default=True,
    needs=frozenset({'warmth'}))
