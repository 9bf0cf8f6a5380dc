"""What a diagnosis came to: each hidden effect found, named beside, confused, or missed."""

from ..effects import EFFECTS
from ..residual.diagnosis import CONFIRMED, UNKNOWN
from ..residual.tracing.confusable import NO_MOTION
from .effect_cases import FROM_OUTSIDE, NOT_IN_VOCABULARY

FOUND = 'found'
BOTH = 'both named'                # of a set that recordings may not tell apart, with advice
EXCLUDED = 'excluded'              # from outside, not named: no effect of the model was made of it
WRONG_JOINT = 'wrong joint'        # or one joint too many, or too few
OTHER_VARIABLES = 'other variables'
NO_VARIABLE = 'unknown without a variable'   # `time` where nothing else fits and nothing rings
ALTERNATIVE = 'alternative only'
SUSPECTED = 'suspected'
CONFUSED = 'confused'
MISSED = 'missed'
RIGHT = (FOUND, BOTH)
# Sets of section 4 of the design that one recording may not tell apart.
DESIGN_SETS = (
    {'gravity_spring', 'link_inertia'}, {'gravity_spring', 'cable_drag'},
    {'presliding_hysteresis', 'stribeck_friction'},
    {'temperature_dependent_coulomb_friction', 'temperature_dependent_viscous_friction'},
    {'base_tilt', 'link_inertia'})
# And one more: an offset and a friction of unequal levels are the same while a joint slides, and
# where contacts bend only reversals of less than their travel tell.
INSEPARABLE = (*DESIGN_SETS, {'torque_offset', 'friction_asymmetry'})
# And one where the report says that no motion of the arm in its mounting does.
FIRST_LINK = {'rotor_inertia', 'link_inertia'}
# Standard errors by which an alternative may be behind and still not be told from a finding.
UNTOLD = 3.0
# Share of its true value by which a swing's frequency may be off: a spectrum over ten seconds
# tells 1 Hz from 1.1 Hz.
FREQUENCY_OFF = 0.1


def judge(result, widely=False):
    """
    Return ([outcome per hidden effect], [names of confirmed findings that none of them explains]).

    An outcome is {name, strength, outcome, joint_right}; a case that failed missed everything.
    widely: naming both is right not for DESIGN_SETS only, but for what the tool itself says that
    no motion separates, too.
    """
    findings = result.get('findings', [])
    claimed = {k for effect in result['effects'] for k, finding in enumerate(findings)
               if _belongs(finding, effect, widely)}
    false = [f['name'] for k, f in enumerate(findings)
             if f['verdict'] == CONFIRMED and k not in claimed]
    outcomes = [{'name': effect['name'], 'strength': effect['strength'],
                 # A case that failed kept nothing out of the model: it said nothing.
                 'outcome': MISSED if 'failed' in result
                 else _outcome(effect, result, false, widely),
                 'joint_right': _joint_right(effect, findings)} for effect in result['effects']]
    return outcomes, false


def kept_out(result):
    """
    Tell whether nothing was taken for an effect of the arm that is none.

    Nor suspected as one: what is suspected is in the model written, too.
    """
    return 'failed' not in result and not judge(result)[1] and not any(
        f['verdict'] == SUSPECTED and f['name'] in (*EFFECTS, 'link_inertia')
        for f in result['findings'])


def naming(findings, effect):
    """Return the first confirmed finding that names a hidden effect at its joints, or None."""
    return next((f for f in findings if f['verdict'] == CONFIRMED and _here(f, effect)
                 and f['name'] == _name(effect)), None)


def _name(effect):
    """Return what a report has to call a hidden effect."""
    return UNKNOWN if effect['name'] in NOT_IN_VOCABULARY else effect['name']


def _here(finding, effect):
    """Tell whether a finding speaks of the effect's joints, all and no other; any for the arm."""
    return not effect['joints'] or set(effect['joints']) == set(finding['joints'])


def _both_named(finding, name, widely):
    """Tell whether a finding names an effect as one that nobody could tell from it."""
    others = [other for other in finding['alternatives_detail'] if other['effect'] == name]
    if not finding['advice'] or not any(_untold(other, finding) for other in others):
        return False
    pair = {finding['name'], name}
    if widely and pair == FIRST_LINK:
        return finding['advice'].startswith(NO_MOTION)
    return pair in (INSEPARABLE if widely else DESIGN_SETS)


def _untold(other, finding):
    """Tell whether the recordings do not tell an alternative from a finding at its joints."""
    # What happened once has no standard error: nothing says that it could not be told.
    close = other['std'] is not None and (
        other['behind'] <= 0.0 or other['behind'] < UNTOLD * other['std'])
    return close and set(other['joints']) == set(finding['joints'])


def _belongs(finding, effect, widely):
    """Tell whether a finding is about a hidden effect, and no false one."""
    if not _here(finding, effect):
        return False
    if effect['name'] in NOT_IN_VOCABULARY:
        # That something is there, without a word on what, is not false.
        return finding['name'] == UNKNOWN and _variables(finding) in ([], *_allowed(effect))
    return finding['name'] == effect['name'] or _both_named(finding, effect['name'], widely)


def _joint_right(effect, findings):
    """Return whether any confirmed finding is at the effect's joint; None for the whole arm."""
    if not effect['joints']:
        return None
    return any(f['verdict'] == CONFIRMED and _here(f, effect) for f in findings)


def _outcome(effect, result, false, widely):
    if effect['name'] in NOT_IN_VOCABULARY:
        return _outside(effect, result, false)
    name, findings = effect['name'], result['findings']
    confirmed = [f for f in findings if f['verdict'] == CONFIRMED]
    here = [f for f in confirmed if _here(f, effect)]
    tests = (
        (FOUND, naming(findings, effect) is not None),
        (BOTH, any(_both_named(f, name, widely) for f in here)),
        (WRONG_JOINT, any(f['name'] == name for f in confirmed)),
        (ALTERNATIVE, any(name == other['effect'] for f in here
                          for other in f['alternatives_detail'])),
        (SUSPECTED, any(f['name'] == name and _here(f, effect) for f in findings)),
        (CONFUSED, bool(false)),
        (EXCLUDED, name in FROM_OUTSIDE))
    return next((outcome for outcome, holds in tests if holds), MISSED)


def _outside(effect, result, false):
    """Judge an effect that no model knows: a confirmed `unknown` with its variable alone."""
    unknown = [f for f in result['findings'] if f['name'] == UNKNOWN and _here(f, effect)]
    right = [f for f in unknown if _variables(f) in _allowed(effect)
             and _rings_right(f, result['parameters'])]
    if not unknown:
        return CONFUSED if false else MISSED
    if not right:
        return OTHER_VARIABLES if any(map(_variables, unknown)) else NO_VARIABLE
    if false:
        return CONFUSED
    return FOUND if any(f['verdict'] == CONFIRMED for f in right) else SUSPECTED


def _allowed(effect):
    """Return the lists of variables that are right for an effect that no model knows."""
    return [[variable] for variable in NOT_IN_VOCABULARY[effect['name']]]


def _variables(finding):
    """Return the variables a finding names; `time` only where it tells a rhythm too."""
    # Joints whose residual follows nothing are said to depend on time, whatever the cause: that
    # alone recognises nothing. A frequency is told only where the residual rings with it.
    return [variable for variable in finding['variables']
            if variable != 'time' or 'frequency' in finding['parameters']]


def _rings_right(finding, figures):
    """Tell whether a frequency [Hz] is the true one, where the plant has one."""
    true = [figure['truth'] for figure in figures if figure['parameter'] == 'frequency']
    told = finding['parameters'].get('frequency')
    return not true or (told is not None
                        and abs(told['mean'] - true[0]) <= FREQUENCY_OFF * true[0])
