"""Effects that look alike, and the motion that tells them apart."""

import numpy as np

# What is said of effects that ask for the same torque in every motion of the arm as it stands.
NO_MOTION = 'no motion of the arm in this mounting separates'
# What is said of effects that have been found alike and of which nobody knows how to part them.
NO_KNOWN_MOTION = 'no motion is known that separates it from'
_SAME = 1e-6  # [-] of a column's length that may be left of it
# Of two that DESIGN section 4 calls hard to tell apart, or that differ only where friction turns,
# both are named where the lesser gains at least this share: their formulas are no exacter than
# that, whatever the blocks prefer.
CLOSE = 0.97
_TOGETHER = tuple(map(frozenset, (
    ('gravity_spring', 'link_inertia'), ('gravity_spring', 'cable_drag'),
    ('presliding_hysteresis', 'stribeck_friction'), ('base_tilt', 'link_inertia'),
    ('temperature_dependent_coulomb_friction', 'temperature_dependent_viscous_friction'),
    ('friction_asymmetry', 'torque_offset'))))
# Gravity's torque on a joint changes with the joints before it, that of its own parts does not.
_OTHER_POSES = ('move the joint over the same range with the joints before it in several poses: '
                'what sits at the joint stays, gravity does not')
_SPEEDS = 'move the joint at constant speeds from very slow to fast'

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
    frozenset({'base_tilt', 'cable_drag'}): _OTHER_POSES,
    frozenset({'base_tilt', 'gravity_spring'}): _OTHER_POSES,
    frozenset({'base_tilt', 'torque_offset'}): _OTHER_POSES,
    frozenset({'cable_drag', 'link_inertia'}): _OTHER_POSES,
    frozenset({'link_inertia', 'torque_offset'}): _OTHER_POSES,
    frozenset({'cable_drag', 'torque_offset'}):
        'move the joint over its whole range: an offset stays, a cable does not',
    frozenset({'gravity_spring', 'torque_offset'}):
        'move the joint over its whole range: an offset stays, a spring does not',
    frozenset({'base_tilt', 'torque_scale'}):
        'hold a known load: a wrong gain scales its torque, a leaning base turns it',
    frozenset({'cable_drag', 'torque_scale'}):
        'hold a known load: a wrong gain misreads it, a cable does not',
    frozenset({'gravity_spring', 'torque_scale'}):
        'hold a known load: a wrong gain misreads it, a spring does not',
    frozenset({'load_dependent_friction', 'torque_scale'}):
        'move the joint slowly there and back in poses of large gravity torque: friction turns, '
        'a gain does not',
    frozenset({'load_dependent_friction', 'presliding_hysteresis'}):
        'reverse the joint over a few milliradians in poses of small and of large gravity torque',
    frozenset({'load_dependent_friction', 'stribeck_friction'}):
        'move the joint at constant speeds from very slow to fast, in poses of small and of large '
        'gravity torque',
    frozenset({'load_dependent_friction', 'viscous_friction'}):
        'move the joint at several constant speeds in poses of small and of large gravity torque',
    frozenset({'stribeck_friction', 'viscous_friction'}): _SPEEDS,
    frozenset({'shear_thinning_friction', 'viscous_friction'}): _SPEEDS,
    frozenset({'coulomb_friction', 'shear_thinning_friction'}): _SPEEDS,
    frozenset({'shear_thinning_friction', 'stribeck_friction'}): _SPEEDS,
    frozenset({'shear_thinning_friction', 'temperature_dependent_viscous_friction'}):
        'record cold and warm, at several constant speeds',
    frozenset({'load_dependent_friction', 'shear_thinning_friction'}):
        'move the joint at several constant speeds in poses of small and of large gravity torque',
    frozenset({'coulomb_friction', 'viscous_friction'}):
        'move the joint at constant speeds from slow to fast',
    frozenset({'backlash', 'presliding_hysteresis'}):
        'reverse the joint where gravity keeps loading its gear to one side: play does not show '
        'there, friction turns all the same',
    frozenset({'time_delay', 'viscous_friction'}):
        'move the joint at one speed where gravity\'s torque changes with its position and where '
        'it does not: a delay shows in the first only',
    frozenset({'torque_scale', 'torque_offset'}):
        'hold still in poses of small and of large gravity torque, to both sides',
    frozenset({'temperature_dependent_coulomb_friction', 'torque_scale_temperature'}):
        'hold a known load still, cold and warm: a gain misreads it, friction does not',
    frozenset({'coulomb_friction', 'temperature_dependent_coulomb_friction'}):
        'record cold and warm, at several constant speeds',
    # While a joint slides, both levels of friction moved by the same are a constant.
    frozenset({'torque_offset', 'friction_asymmetry'}):
        'reverse the joint many times over less than a milliradian, where contacts bend and do '
        'not slide: all of an offset stays, of unequal levels a part; or read the effort while '
        'the brakes hold the joint: an offset of the sensor stays',
    frozenset({'torque_ripple', 'cable_drag'}):
        'move the joint slowly at constant speed over its whole range',
    frozenset({'coulomb_friction', 'presliding_hysteresis'}):
        'reverse the joint over a few milliradians and over a whole turn',
    frozenset({'coulomb_friction', 'load_dependent_friction'}):
        'move the joint slowly in poses of small and of large gravity torque',
    frozenset({'coulomb_friction', 'stribeck_friction'}): _SPEEDS,
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
# Of causes so unlike that one is never taken for a change of the other, but that a single short
# recording may leave open.
_UNLIKE = {
    **{frozenset({'time_delay', name}): (
        'move along the same path at two speeds: a delay asks for more torque the faster the '
        'torque changes, what follows position stays the same')
       for name in ('gravity_spring', 'cable_drag', 'torque_ripple', 'base_tilt')},
    frozenset({'presliding_hysteresis', 'time_delay'}):
        'reverse the joint slowly and quickly over the same path: friction turns over the same '
        'distance, a delay lasts the same time',
    frozenset({'presliding_hysteresis', 'torque_ripple'}):
        'move the joint on at constant speed after a reversal: friction has turned once, a ripple '
        'goes on'}
# And of what is none of the vocabulary.
_BESIDE = {frozenset({'time_delay', 'effort_filter'}):
           'move along the same path slowly and quickly: a delay stays the same time, a filter '
           'takes off the more of a torque, the quicker it changes'}
_MOTIONS = {**PAIRS, **_UNLIKE, **_BESIDE}


def partners(name):
    """Return the effects that may look like the named one."""
    return sorted({other for pair in PAIRS if name in pair for other in pair - {name}})


def advice(name, others):
    """Return the motions (a sentence each) that separate an effect from others, and if none is."""
    others = [other for other in dict.fromkeys(others) if other != name]
    found = [_MOTIONS[pair] for other in others if (pair := frozenset({name, other})) in _MOTIONS]
    without = [other for other in others if frozenset({name, other}) not in _MOTIONS]
    if without:
        found.append(f'{NO_KNOWN_MOTION} {", ".join(without)}')
    return '; '.join(dict.fromkeys(found))


def named_together(best, other):
    """Tell whether the lesser of two Candidates is named too: of _TOGETHER, if close."""
    pair = frozenset({best.name, other.name})
    # A leaning base is no joint's own; of all others only those of one joint look alike.
    return pair in _TOGETHER and (best.joints == other.joints or 'base_tilt' in pair) \
        and other.gain > CLOSE * best.gain


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
