"""Effects that look alike, and the motion that tells them apart."""

from ...effects import EFFECTS

# What is said of effects that ask for the same torque in every motion of the arm as it stands.
NO_MOTION = 'no motion of the arm in this mounting separates'
# What is said of effects that have been found alike and of which nobody knows how to part them.
NO_KNOWN_MOTION = 'no motion is known that separates it from'
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
_OTHER_POSES = ('move the joint over the same range with the joints before it (of the first '
                'joint: those behind it) in several poses: what sits at the joint stays, gravity '
                'does not')
# Where it does not change with them.
_WHOLE_RANGE = ('move the joint over a whole turn, or as much of it as there is: the torque of a '
                'weight is a sine of its angle, {} is not')
_WARMTHS = 'record at three temperatures, or while the arm warms'
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
        f'{_WARMTHS}, at several constant speeds from slow to fast',
    frozenset({'base_tilt', 'link_inertia'}):
        'move every joint through its range, an upright first one through a whole turn with the '
        'arm stretched out: a leaning base turns the weight of all links, a heavier link adds to '
        'its own',
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
        'move with a known load: a wrong gain scales its torque, a leaning base turns it',
    frozenset({'cable_drag', 'torque_scale'}):
        'move with a known load: a wrong gain misreads it, a cable does not',
    frozenset({'gravity_spring', 'torque_scale'}):
        'move with a known load: a wrong gain misreads it, a spring does not',
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
        f'{_WARMTHS}, at several constant speeds',
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
        'move slowly there and back through poses of small and of large gravity torque, to both '
        'sides',
    frozenset({'temperature_dependent_coulomb_friction', 'torque_scale_temperature'}):
        f'{_WARMTHS}, with a known load, slowly there and back: a gain misreads its weight, '
        'friction turns with the motion',
    frozenset({'coulomb_friction', 'temperature_dependent_coulomb_friction'}):
        f'{_WARMTHS}, at several constant speeds',
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
        f'{_WARMTHS}, at several constant speeds',
    frozenset({'torque_scale', 'link_inertia'}):
        'move with a known load: a wrong gain misreads it, a wrong link does not',
    frozenset({'torque_scale', 'torque_scale_temperature'}): _WARMTHS,
    frozenset({'rotor_inertia', 'link_inertia'}):
        'accelerate the joints before it while this one stands: its link shows, its rotor does '
        'not',
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
           'takes off the more of a torque, the quicker it changes',
           # Of a link and the next.
           frozenset({'link_inertia'}):
           'turn the joint between both links through its range; what of a link that joint does '
           'not move is the same on the link before it, so look at both'}
_MOTIONS = {**PAIRS, **_UNLIKE, **_BESIDE}
# Of a joint whose weight does not change with the joints before it.
_OF_ITS_OWN_WEIGHT = {
    frozenset({'cable_drag', 'link_inertia'}): _WHOLE_RANGE.format('that of a cable'),
    frozenset({'link_inertia', 'torque_offset'}): _WHOLE_RANGE.format('an offset')}


def partners(name):
    """Return the effects that may look like the named one."""
    return sorted({other for pair in PAIRS if name in pair for other in pair - {name}})


def advice(name, others, own_weight=False):
    """
    Return the motions (a sentence each) that separate an effect from others, and if none is.

    own_weight: whether gravity's torque on the joint does not change with the joints before it.
    """
    motions = {**_MOTIONS, **(_OF_ITS_OWN_WEIGHT if own_weight else {})}
    # Its own name on other joints is another cause of a link only.
    pairs = {other: pair for other in others if (pair := frozenset({name, other})) in motions
             or other != name}
    found = [motions.get(pair) or _apart(name, other) for other, pair in pairs.items()]
    without = [other for other, told in zip(pairs, found) if not told]
    if without:
        found.append(f'{NO_KNOWN_MOTION} {", ".join(without)}')
    return '; '.join(dict.fromkeys(filter(None, found)))


def _apart(name, other):
    """Return the motion that separates what follows different variables, '' of the same."""
    own, others = (EFFECTS[what].against if what in EFFECTS else '' for what in (name, other))
    if not own or not others or own == others:
        return ''
    return (f'{name} follows {own}, {other} {others}: move so that either covers its range while '
            'the other hardly changes')


def named_together(best, other):
    """Tell whether the lesser of two Candidates is named too: of _TOGETHER, if close."""
    pair = frozenset({best.name, other.name})
    # A leaning base is no joint's own; of all others only those of one joint look alike.
    return pair in _TOGETHER and (best.joints == other.joints or 'base_tilt' in pair) \
        and other.gain > CLOSE * best.gain
