"""Turn requests of an effects file into parameters of the truth."""

import numpy as np

from ...errors import ConfigurationError
from ..arm import Arm
from .contact import ExternalContact, SwingingLoad
from .effort import (SaturatingDrive, TimeDelay, TorqueOffset, TorqueScale,
                     TorqueScaleTemperature)
from .friction import (CoulombFriction, FrictionAsymmetry, LoadDependentFriction,
                       PreslidingHysteresis, ShearThinningFriction, SpeedResonanceFriction,
                       StribeckFriction, TemperatureDependentCoulomb,
                       TemperatureDependentViscous, ViscousFriction)
from .gear import Backlash
from .load import LoadChange
from .position import CableDrag, GravitySpring, TorqueRipple
from .reference_motion import ReferenceMotion
from .rigid import BaseTilt, LinkInertia, RotorInertia

EFFECTS = {kind.name: kind for kind in (
    LinkInertia(), RotorInertia(), BaseTilt(), GravitySpring(), CableDrag(), CoulombFriction(),
    ViscousFriction(), FrictionAsymmetry(), StribeckFriction(), LoadDependentFriction(),
    TemperatureDependentViscous(), TemperatureDependentCoulomb(), PreslidingHysteresis(),
    Backlash(), TorqueRipple(), TorqueScale(), TorqueScaleTemperature(), TorqueOffset(),
    TimeDelay(), ExternalContact(), SpeedResonanceFriction(), SwingingLoad(), LoadChange(),
    ShearThinningFriction(), SaturatingDrive())}
# Halvings of the logarithm of an amplitude: five decades to half a percent.
_BISECTIONS = 11


def apply_effects(requests, robot, truth, seed):
    """
    Write the requested effects into the truth.

    requests: EffectRequest of read_effects. Strengths count against the truth before any effect
    and what a file leaves open is drawn by `seed`. Raises ConfigurationError for a strength that
    the effect cannot reach.
    """
    if not requests:
        return
    motion = ReferenceMotion(robot, truth, Arm(robot, truth.links, truth.rotor, truth.gravity))
    found = []
    for request in requests:
        effect = EFFECTS[request.name]
        rng = np.random.default_rng([seed, 3, list(EFFECTS).index(request.name)])
        values = effect.draw(rng, truth, motion)
        for name, value in request.parameters.items():
            values[name] = _place(effect, value, values.get(name), request, robot.n)
        if request.strength is not None:
            values[effect.amplitude] = _amplitude(request, effect, values, motion, truth)
        found.append((effect, values))
    for effect, values in found:
        effect.apply(truth, values)


def _place(effect, value, drawn, request, n):
    """Return a file's value; per joint as (n,), as drawn or zero on the joints not listed."""
    if not effect.per_joint:
        return value
    column = np.zeros(n) if drawn is None else np.array(drawn)
    column[list(request.joints)] = value
    return column


def _amplitude(request, effect, values, motion, truth):
    """Return the amplitude whose RMS torque over noise is the strength on the joints listed."""
    listed = np.zeros(motion.robot.n, dtype=bool)
    listed[list(request.joints)] = True

    def ratio(amplitude):
        if effect.per_joint:
            amplitude = np.where(listed, amplitude, 0.0)
        torque = effect.torque_along(motion, truth, {**values, effect.amplitude: amplitude})
        over = np.sqrt(np.mean(torque ** 2, axis=0)) / truth.noise
        return np.full(len(over), np.max(over)) if effect.shared else over

    low, high = (np.broadcast_to(bound, listed.shape) for bound in effect.bounds(truth))
    if effect.linear:
        per_unit = np.maximum(ratio(1.0 if not effect.per_joint else listed * 1.0), 1e-12)
        wanted, reach = request.strength / per_unit, high * per_unit
        reach = np.where(per_unit > 1e-9, reach, 0.0)
    else:
        wanted, reach = _bisect(ratio, request.strength, low, high, effect.per_joint)
    if np.any(reach[listed] < request.strength):
        raise ConfigurationError(request.where, f'{request.name} cannot be so strong on every '
                                 'joint listed', request.strength,
                                 f'strength up to {np.min(reach[listed]):.3g}',
                                 'choose other joints or a lower strength')
    return np.where(listed, wanted, 0.0) if effect.per_joint else float(wanted[0])


def _bisect(ratio, strength, low, high, per_joint):
    """Return the amplitude (n,) with ratio = strength, and the ratio (n,) at the highest."""
    reach = ratio(high if per_joint else high[0])
    low, high = np.log(low), np.log(high)
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        above = ratio(np.exp(middle) if per_joint else np.exp(middle[0])) >= strength
        high, low = np.where(above, middle, high), np.where(above, low, middle)
    return np.exp(0.5 * (low + high)), reach
