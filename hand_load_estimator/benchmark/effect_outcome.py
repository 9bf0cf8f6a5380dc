"""What a diagnosis came to: each hidden effect found, named beside, confused, or missed."""

from ..residual.confusable import NO_MOTION
from ..residual.diagnosis import CONFIRMED, UNKNOWN
from .effect_cases import CONTACT, NOT_IN_VOCABULARY, OUTSIDE

FOUND = 'found'
BOTH = 'both named'                # of a set that recordings may not tell apart, with advice
EXCLUDED = 'excluded'              # a contact that no effect of the model was made of
WRONG_JOINT = 'wrong joint'
OTHER_VARIABLES = 'other variables'
NO_VARIABLE = 'unknown without a variable'   # `time` where nothing else fits and nothing rings
ALTERNATIVE = 'alternative only'
SUSPECTED = 'suspected'
CONFUSED = 'confused'
MISSED = 'missed'
RIGHT = (FOUND, BOTH, EXCLUDED)
# Sets of section 4 of the design that one recording may not tell apart.
DESIGN_SETS = (
    {'gravity_spring', 'link_inertia'}, {'gravity_spring', 'cable_drag'},
    {'presliding_hysteresis', 'stribeck_friction'},
    {'temperature_dependent_coulomb_friction', 'temperature_dependent_viscous_friction'},
    {'base_tilt', 'link_inertia'})
# And one more: an offset and a friction of unequal levels differ only at standstill, where
# presliding hides either.
INSEPARABLE = (*DESIGN_SETS, {'torque_offset', 'friction_asymmetry'})


def judge(result, strictly=False):
    """
    Return ([outcome per hidden effect], [names of confirmed findings that none of them explains]).

    An outcome is {name, strength, outcome, joint_right}; a case that failed missed everything.
    strictly: naming both is right for DESIGN_SETS only, not for what the tool itself says that
    no motion separates.
    """
    findings = result.get('findings', [])
    claimed = {k for effect in result['effects'] for k, finding in enumerate(findings)
               if _belongs(finding, effect, result['kind'], strictly)}
    false = [f['name'] for k, f in enumerate(findings)
             if f['verdict'] == CONFIRMED and k not in claimed]
    outcomes = [{'name': effect['name'], 'strength': effect['strength'],
                 # A case that failed kept nothing out of the model: it said nothing.
                 'outcome': MISSED if 'failed' in result
                 else _outcome(effect, findings, result['kind'], false, strictly),
                 'joint_right': _joint_right(effect, findings)} for effect in result['effects']]
    return outcomes, false


def _here(finding, effect):
    """Tell whether a finding speaks of the effect's joint; arm-wide ones speak of every joint."""
    return (not effect['joints'] or not finding['joints']
            or bool(set(effect['joints']) & set(finding['joints'])))


def _alternatives(finding):
    return {other['effect'] for other in finding['alternatives']}


def _both_named(finding, name, strictly):
    # Recordings may not tell some sets apart, and some pairs nothing can: then both are right.
    if name not in _alternatives(finding) or not finding['advice']:
        return False
    if not strictly and finding['advice'].startswith(NO_MOTION):
        return True
    sets = DESIGN_SETS if strictly else INSEPARABLE
    return any({finding['name'], name} <= group for group in sets)


def _belongs(finding, effect, kind, strictly):
    """Tell whether a finding is about a hidden effect, and no false one."""
    if not _here(finding, effect):
        return False
    if kind == OUTSIDE:
        return finding['name'] == UNKNOWN
    return finding['name'] == effect['name'] or _both_named(finding, effect['name'], strictly)


def _joint_right(effect, findings):
    """Return whether any confirmed finding is at the effect's joint; None for the whole arm."""
    if not effect['joints']:
        return None
    return any(f['verdict'] == CONFIRMED and _here(f, effect) for f in findings)


def _outcome(effect, findings, kind, false, strictly):
    if kind == OUTSIDE:
        return _outside(effect, findings, false)
    if effect['name'] == CONTACT:
        return _contact(findings, false)
    name, confirmed = effect['name'], [f for f in findings if f['verdict'] == CONFIRMED]
    here = [f for f in confirmed if _here(f, effect)]
    tests = (
        (FOUND, any(f['name'] == name for f in here)),
        (BOTH, any(_both_named(f, name, strictly) for f in here)),
        (WRONG_JOINT, any(f['name'] == name for f in confirmed)),
        (ALTERNATIVE, any(name in _alternatives(f) for f in here)),
        (SUSPECTED, any(f['name'] == name and _here(f, effect) for f in findings)),
        (CONFUSED, bool(false)))
    return next((outcome for outcome, holds in tests if holds), MISSED)


def _outside(effect, findings, false):
    """Judge an effect that no model knows: `unknown`, with one of its variables named."""
    unknown = [f for f in findings if f['name'] == UNKNOWN and _here(f, effect)]
    words = NOT_IN_VOCABULARY[effect['name']]
    if any(word in _variables(f) for f in unknown for word in words):
        return CONFUSED if false else FOUND
    if unknown:
        return OTHER_VARIABLES if any(map(_variables, unknown)) else NO_VARIABLE
    return CONFUSED if false else MISSED


def _variables(finding):
    """Return the variables a finding names; `time` only where it tells a rhythm too."""
    # Joints whose residual follows nothing are said to depend on time, whatever the cause: that
    # alone recognises nothing. A frequency is told only where the residual rings with it.
    return ' '.join(variable.lower() for variable in finding['variables']
                    if variable != 'time' or 'frequency' in finding['parameters'])


def _contact(findings, false):
    """Judge a contact: named, or at least not taken for an effect of the model."""
    if false:
        return CONFUSED
    return FOUND if any(f['name'] == CONTACT for f in findings) else EXCLUDED
