"""The vocabulary of joint effects a torque model may declare (names as in reports)."""

from .drive import OFFSET, ROTOR
from .effect import Effect, EffectInput, Shape
from .friction import (ASYMMETRY, COULOMB, COULOMB_TEMPERATURE, PRESLIDING, STRIBECK, VISCOUS,
                       VISCOUS_TEMPERATURE)

EFFECTS = {effect.name: effect for effect in (
    ROTOR, COULOMB, VISCOUS, ASYMMETRY, STRIBECK, PRESLIDING, VISCOUS_TEMPERATURE,
    COULOMB_TEMPERATURE, OFFSET)}

# Effects that need temperatures; identification leaves them out when there are none.
NEEDS_TEMPERATURE = frozenset({VISCOUS_TEMPERATURE.name, COULOMB_TEMPERATURE.name})

# What `identify` declares unless --effects says otherwise; link_inertia is the rigid body's.
DEFAULT_EFFECTS = ('link_inertia', *EFFECTS)

__all__ = ['DEFAULT_EFFECTS', 'EFFECTS', 'NEEDS_TEMPERATURE', 'Effect', 'EffectInput', 'Shape']
