"""The vocabulary of effects a torque model may declare (names as in reports), one file each."""

from .backlash import BACKLASH
from .base_tilt import BASE_TILT
from .cable_drag import CABLE_DRAG
from .coulomb_friction import COULOMB_FRICTION
from .effect import Described, Effect, EffectInput, Shape
from .external_contact import EXTERNAL_CONTACT
from .friction_asymmetry import FRICTION_ASYMMETRY
from .gravity_spring import GRAVITY_SPRING
from .learned_correction import LEARNED_POSITION_CORRECTION, LEARNED_VELOCITY_CORRECTION
from .link_inertia import LINK_INERTIA
from .load_change import LOAD_CHANGE
from .load_dependent_friction import LOAD_DEPENDENT_FRICTION
from .presliding_hysteresis import PRESLIDING, PRESLIDING_HYSTERESIS
from .rotor_inertia import ROTOR_INERTIA
from .shear_thinning_friction import SHEAR_THINNING_FRICTION
from .stribeck_friction import STRIBECK_FRICTION
from .temperature_dependent_coulomb_friction import TEMPERATURE_DEPENDENT_COULOMB_FRICTION
from .temperature_dependent_viscous_friction import TEMPERATURE_DEPENDENT_VISCOUS_FRICTION
from .time_delay import LATE, TIME_DELAY
from .torque_offset import TORQUE_OFFSET
from .torque_ripple import TORQUE_RIPPLE
from .torque_scale import TORQUE_SCALE
from .torque_scale_temperature import TORQUE_SCALE_TEMPERATURE
from .viscous_friction import VISCOUS_FRICTION

EFFECTS = {effect.name: effect for effect in (
    ROTOR_INERTIA, COULOMB_FRICTION,
    VISCOUS_FRICTION, FRICTION_ASYMMETRY,
    SHEAR_THINNING_FRICTION,
    STRIBECK_FRICTION, PRESLIDING_HYSTERESIS,
    TEMPERATURE_DEPENDENT_VISCOUS_FRICTION, TEMPERATURE_DEPENDENT_COULOMB_FRICTION,
    TORQUE_OFFSET, BASE_TILT,
    GRAVITY_SPRING, CABLE_DRAG,
    LOAD_DEPENDENT_FRICTION, BACKLASH,
    TORQUE_RIPPLE, TORQUE_SCALE,
    TORQUE_SCALE_TEMPERATURE, TIME_DELAY,
    LEARNED_VELOCITY_CORRECTION, LEARNED_POSITION_CORRECTION)}

# What a report may name beside them: the rigid body's own, and what acts from outside for a time.
DESCRIBED = {entry.name: entry for entry in (LINK_INERTIA, EXTERNAL_CONTACT, LOAD_CHANGE)}

# Effects that need temperatures; identification leaves them out when there are none.
NEEDS_TEMPERATURE = frozenset(e.name for e in EFFECTS.values() if 'warmth' in e.needs)

# What `identify` declares unless --effects says otherwise; link_inertia is the rigid body's.
DEFAULT_EFFECTS = ('link_inertia', *(e.name for e in EFFECTS.values() if e.default))

__all__ = ['DEFAULT_EFFECTS', 'DESCRIBED', 'EFFECTS', 'EXTERNAL_CONTACT', 'LATE',
           'LINK_INERTIA', 'LOAD_CHANGE', 'NEEDS_TEMPERATURE', 'PRESLIDING', 'Described', 'Effect',
           'EffectInput', 'Shape']
