"""Effects that look alike, and the motion that tells them apart."""

import numpy as np

# What is said of effects that ask for the same torque in every motion of the arm as it stands.
NO_MOTION = 'no motion of the arm in this mounting separates'
_SAME = 1e-6  # [-] of a column's length that may be left of it

# Pairs that recordings may not separate, with the motion that would.
PAIRS = {
    frozenset({'gravity_spring', 'link_inertia'}):
        'move the joint fast and slowly over the same range: a link resists acceleration too, a '
        'spring does not; or weigh the arm in another mounting',
    frozenset({'gravity_spring', 'cable_drag'}):
        'move the joint over a whole turn: a spring repeats after it, a cable does not',
    frozenset({'presliding_hysteresis', 'stribeck_friction'}):
        'reverse the joint many times at low speed over a few milliradians, then creep at '
        'constant low speed',
    frozenset({'temperature_dependent_coulomb_friction',
               'temperature_dependent_viscous_friction'}):
        'record at two temperatures, each at several constant speeds from slow to fast',
    frozenset({'base_tilt', 'link_inertia'}):
        'turn the first joint through a whole turn with the arm stretched out: a leaning base '
        'shows once per turn, a heavier link does not',
    frozenset({'torque_offset', 'friction_asymmetry'}):
        'move the joint back and forth at several speeds, and hold it still between',
    frozenset({'torque_ripple', 'cable_drag'}):
        'move the joint slowly at constant speed over its whole range',
    frozenset({'coulomb_friction', 'presliding_hysteresis'}):
        'reverse the joint over a few milliradians and over a whole turn',
    frozenset({'coulomb_friction', 'load_dependent_friction'}):
        'move the joint slowly in poses of small and of large gravity torque',
    frozenset({'coulomb_friction', 'stribeck_friction'}):
        'move the joint at constant speeds from very slow to fast',
    frozenset({'viscous_friction', 'temperature_dependent_viscous_friction'}):
        'record cold and warm, at several constant speeds',
    frozenset({'torque_scale', 'link_inertia'}):
        'hold a known load: a wrong gain misreads it, a wrong link does not',
    frozenset({'torque_scale', 'torque_scale_temperature'}): 'record cold and warm',
    frozenset({'rotor_inertia', 'link_inertia'}):
        'accelerate the joint in several poses of the joints behind it',
    frozenset({'backlash', 'time_delay'}):
        'move the joint where gravity keeps loading its gear to one side, fast: play does not '
        'show there, a delay does',
    frozenset({'rotor_inertia', 'time_delay'}):
        'accelerate hard at high and at low speed: a delay follows the torque\'s rate, a rotor '
        'the acceleration'}


def partners(name):
    """Return the effects that may look like the named one."""
    return sorted({other for pair in PAIRS if name in pair for other in pair - {name}})


def advice(name, others):
    """Return the motions (a sentence each) that separate an effect from others."""
    found = [PAIRS[pair] for other in others if (pair := frozenset({name, other})) in PAIRS]
    return '; '.join(dict.fromkeys(found))


def same_torque(simple, other):
    """
    Tell whether an effect can do nothing but what a simpler one does on the same joint.

    simple (N, 1), other (N, k): their torque columns there. The first link of an upright arm is
    such a case: it only turns about the joint's own axis, as the rotor does, so that recordings
    give the sum of both inertias and nothing else.
    """
    axis = simple[:, 0] / max(np.linalg.norm(simple), 1e-300)
    left = other - np.outer(axis, axis @ other)
    return bool(np.linalg.norm(left) < _SAME * np.linalg.norm(other))
