"""Outcomes of the effects suite: every hidden effect is judged as stated."""

from effects_suite_helpers import finding, JOINT, OTHER, other, result, SWING
import pytest

from hand_load_estimator.benchmark.effect_goals import verdicts
from hand_load_estimator.benchmark.effect_outcome import judge
from hand_load_estimator.benchmark.effect_scores import only_widely, totals
from hand_load_estimator.residual.diagnosis import CONFIRMED
from hand_load_estimator.residual.tracing.confusable import NO_MOTION

RESONANCE = 'speed_resonance_friction'

ADVICE = 'turn it once round'


@pytest.mark.parametrize('name, found, outcome, false', [
    ('time_delay', [finding('time_delay')], 'found', []),
    ('time_delay', [finding('time_delay', (OTHER, JOINT))], 'wrong joint', ['time_delay']),
    ('time_delay', [finding('time_delay'), finding('backlash')], 'found', ['backlash']),
    ('time_delay', [finding('time_delay', (OTHER,))], 'wrong joint', ['time_delay']),
    ('time_delay', [finding('time_delay', verdict='suspected')], 'suspected', []),
    ('time_delay', [finding('torque_scale')], 'confused', ['torque_scale']),
    ('time_delay', [finding('torque_scale', verdict='suspected')], 'missed', []),
    ('time_delay', [finding('rotor_inertia', alternatives=[other('time_delay')], advice=ADVICE)],
     'alternative only', ['rotor_inertia']),
    ('cable_drag', [finding('gravity_spring', alternatives=[other('cable_drag')], advice=ADVICE)],
     'both named', []),
    ('cable_drag', [finding('gravity_spring', alternatives=[other('cable_drag')])],
     'alternative only', ['gravity_spring']),
    ('cable_drag', [finding('gravity_spring', advice=ADVICE,
                            alternatives=[other('cable_drag', behind=6.0)])],
     'alternative only', ['gravity_spring']),
    ('cable_drag', [finding('gravity_spring', advice=ADVICE,
                            alternatives=[other('cable_drag', std=None)])],
     'alternative only', ['gravity_spring']),
    ('cable_drag', [finding('gravity_spring', advice=ADVICE,
                            alternatives=[other('cable_drag', (OTHER,))])],
     'alternative only', ['gravity_spring']),
    ('link_inertia', [finding('rotor_inertia', alternatives=[other('link_inertia')],
                              advice=ADVICE)], 'alternative only', ['rotor_inertia']),
    ('cable_drag', [finding('gravity_spring', (OTHER,), CONFIRMED,
                            [other('cable_drag', (OTHER,))], ADVICE)],
     'confused', ['gravity_spring']),
    ('time_delay', [], 'missed', [])])
def test_one_hidden_effect_is_judged(name, found, outcome, false):
    (effect,), wrong = judge(result([(name, (JOINT,))], found))
    assert effect['outcome'] == outcome and wrong == false


@pytest.mark.parametrize('hidden, named, advice, outcome', [
    ('cable_drag', 'gravity_spring', ADVICE, 'both named'),
    ('friction_asymmetry', 'torque_offset', ADVICE, 'alternative only'),
    ('link_inertia', 'rotor_inertia', f'{NO_MOTION} them', 'alternative only')])
def test_both_are_right_for_sets_of_the_design_only(hidden, named, advice, outcome):
    case = result([(hidden, (JOINT,))],
                  [finding(named, alternatives=[other(hidden)], advice=advice)])
    (effect,), false = judge(case)
    assert effect['outcome'] == outcome and false == [named] * (outcome != 'both named')
    wide, beside = judge(case, widely=True)
    assert wide[0]['outcome'] == 'both named' and beside == []
    total, wrong = totals([case]), outcome != 'both named'
    assert total['single'] == [1, int(not wrong)] and total['single_widely'] == [1, 1]
    assert only_widely([case]) == ({(hidden, named): 1} if wrong else {})


def test_a_pair_is_counted_strictly_and_with_what_cannot_be_told():
    named = [finding('torque_offset', alternatives=[other('friction_asymmetry')], advice=ADVICE),
             finding('time_delay', (OTHER,))]
    total = totals([result([('friction_asymmetry', (JOINT,)), ('time_delay', (OTHER,))], named,
                           kind='pair')])
    assert total['pairs'] == [1, 0] and total['pairs_widely'] == [1, 1]


def test_what_no_motion_tells_needs_no_standard_error():
    first = finding('rotor_inertia', alternatives=[other('link_inertia', behind=0.0, std=0.0)],
                    advice=f'{NO_MOTION} it')
    wide, beside = judge(result([('link_inertia', (JOINT,))], [first]), widely=True)
    assert wide[0]['outcome'] == 'both named' and beside == []


@pytest.mark.parametrize('alternative', [
    other('friction_asymmetry', behind=6.0), other('friction_asymmetry', (OTHER,))])
def test_widely_too_what_gains_much_more_or_elsewhere_is_told(alternative):
    case = result([('friction_asymmetry', (JOINT,))],
                  [finding('torque_offset', alternatives=[alternative], advice=ADVICE)])
    assert judge(case, widely=True)[0][0]['outcome'] == 'alternative only'


def test_joint_is_right_apart_from_the_name():
    right, wrong, arm = (judge(result([(name, joints)], [finding('torque_scale', (JOINT,))]))
                         [0][0]['joint_right'] for name, joints in
                         (('time_delay', (JOINT,)), ('time_delay', (OTHER,)), ('base_tilt', ())))
    assert (right, wrong, arm) == (True, False, None)


def test_an_effect_of_the_whole_arm_is_right_at_any_joint():
    (effect,), _ = judge(result([('base_tilt', ())], [finding('base_tilt', (JOINT, OTHER))]))
    assert effect['outcome'] == 'found'


def test_each_of_a_pair_is_judged_and_neither_is_the_others_false_finding():
    pair = [('time_delay', (JOINT,)), ('torque_scale', (OTHER,))]
    effects, false = judge(result(pair, [finding('time_delay')], 'pair'))
    assert [e['outcome'] for e in effects] == ['found', 'missed'] and not false
    both = [finding('time_delay'), finding('torque_scale', (OTHER,))]
    assert [e['outcome'] for e in judge(result(pair, both, 'pair'))[0]] == ['found', 'found']


@pytest.mark.parametrize('name, found, outcome', [
    (RESONANCE, [finding('unknown', variables=['velocity'])], 'found'),
    (RESONANCE, [finding('unknown', variables=['velocity'], verdict='suspected')], 'suspected'),
    (RESONANCE, [finding('unknown', variables=['position'])], 'other variables'),
    (RESONANCE, [finding('unknown', variables=[f'velocity of {OTHER}'])], 'other variables'),
    (RESONANCE, [finding('unknown', variables=['velocity', 'position'])], 'other variables'),
    (RESONANCE, [finding('unknown', (OTHER,), variables=['velocity'])], 'confused'),
    (RESONANCE, [finding('unknown', (JOINT, OTHER), variables=['velocity'])], 'confused'),
    (RESONANCE, [finding('stribeck_friction')], 'confused'),
    (RESONANCE, [finding('unknown', variables=['velocity']), finding('stribeck_friction')],
     'confused'),
    (RESONANCE, [finding('unknown', variables=['velocity']),
                 finding('unknown', variables=['position'])], 'confused'),
    (RESONANCE, [], 'missed'),
    ('swinging_load', [finding('unknown', variables=['time'], frequency=1.05)], 'found'),
    ('swinging_load', [finding('unknown', variables=['time'], frequency=1.05,
                               verdict='suspected')], 'suspected'),
    ('swinging_load', [finding('unknown', variables=['time'], frequency=1.15)],
     'other variables'),
    ('swinging_load', [finding('unknown', variables=['acceleration'])], 'other variables'),
    ('swinging_load', [finding('unknown', variables=['time'])], 'unknown without a variable'),
    ('swinging_load', [finding('unknown', variables=['position'])], 'other variables')])
def test_what_no_model_knows_must_be_unknown_with_its_variable(name, found, outcome):
    joints, figures = ((), SWING) if name == 'swinging_load' else ((JOINT,), [])
    (effect,), _ = judge(result([(name, joints)], found, 'outside', 3.0, parameters=figures))
    assert effect['outcome'] == outcome


@pytest.mark.parametrize('name, another', [('external_contact', 'load_change'),
                                           ('load_change', 'external_contact')])
@pytest.mark.parametrize('found, outcome, right, out', [
    (['name'], 'found', 1, 1), ([], 'excluded', 0, 1), (['suspected'], 'suspected', 0, 1),
    (['backlash'], 'confused', 0, 0), (['name', 'backlash'], 'found', 1, 0),
    (['another'], 'confused', 0, 0)])
def test_what_comes_from_outside_is_right_by_name_only(name, another, found, outcome, right, out):
    """Silence was once right for a contact: a report of nothing passed at any strength."""
    words = {'name': finding(name), 'suspected': finding(name, verdict='suspected'),
             'backlash': finding('backlash'), 'another': finding(another)}
    case = result([(name, ())], [words[word] for word in found], torque=(9.0, 9.0))
    assert judge(case)[0][0]['outcome'] == outcome
    total = totals([case])
    assert total['single'] == [1, right] and total['kept_out'] == [1, out]
    assert total['single_alone'] == [1, int(right and out)]
    # No model foretells it: it is in no error goal.
    assert total['ratios'] == []


def test_a_contact_suspected_as_an_effect_is_in_the_model_and_not_kept_out():
    found = [finding('external_contact'), finding('backlash', verdict='suspected')]
    assert totals([result([('external_contact', ())], found)])['kept_out'] == [1, 0]


def test_a_diagnosis_that_failed_reaches_no_goal_of_every_case():
    good = result([('backlash', (JOINT,))], [finding('backlash')])
    rows = {what: (value, reached) for what, _, value, reached in verdicts(
        totals([good, {**good, 'failed': 'refused'}]))}
    value, reached = next(row for what, row in rows.items() if what.startswith('torque error'))
    assert '(1 of 2;' in value and reached is False


def test_a_refused_contact_was_not_kept_out():
    case = {**result([('external_contact', ())], []), 'failed': 'refused'}
    assert judge(case)[0][0]['outcome'] == 'missed' and totals([case])['kept_out'] == [1, 0]


def test_right_with_something_false_beside_counts_in_one_row_only():
    delay = [('time_delay', (JOINT,))]
    total = totals([result(delay, [finding('time_delay')]),
                    result(delay, [finding('time_delay'), finding('backlash')]),
                    result(delay, [finding('time_delay'),
                                   finding('backlash', verdict='suspected')])])
    assert total['single'] == [3, 3] and total['single_alone'] == [3, 2]
