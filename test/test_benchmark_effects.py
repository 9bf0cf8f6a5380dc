"""The effects suite: judged as stated, scored, run from plant to page."""

import json

from core_helpers import four_axes
import numpy as np
from plant_helpers import ur10e
import pytest
import yaml

from hand_load_estimator import cli, seeds
from hand_load_estimator.benchmark import cases, effect_measure, effect_recordings, effect_run
from hand_load_estimator.benchmark.document import blocks_of, to_markdown
from hand_load_estimator.benchmark.effect_cases import EffectCase, Hidden, suite_cases
from hand_load_estimator.benchmark.effect_goals import beyond, verdicts
from hand_load_estimator.benchmark.effect_outcome import judge
from hand_load_estimator.benchmark.effect_page import effects_markdown
from hand_load_estimator.benchmark.effect_scores import (confusions, effect_rows, not_tried,
                                                         only_widely, pair_rows, seen_ratio,
                                                         totals)
from hand_load_estimator.benchmark.share import wilson
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.identification import identify
from hand_load_estimator.residual.confusable import NO_MOTION
from hand_load_estimator.residual.diagnosis import CONFIRMED, Diagnosis, Evidence, Finding

PLANT = seeds.DEVELOPMENT_PLANTS[95]
JOINT, OTHER = 'elbow_joint', 'wrist_1_joint'
RESONANCE = 'speed_resonance_friction'
SWING = [{'effect': 'swinging_load', 'parameter': 'frequency', 'truth': 1.0, 'estimate': 1.0,
          'std': None}]


# Outcomes.

def finding(name, joints=(JOINT,), verdict=CONFIRMED, alternatives=(), advice='', variables=(),
            frequency=None):
    """Return a finding as report.json has it, as far as it is judged."""
    return {'name': name, 'joints': list(joints), 'verdict': verdict,
            'alternatives': list(alternatives), 'advice': advice,
            'variables': list(variables), 'parameters': {} if frequency is None else {
                'frequency': {'mean': frequency, 'std': None, 'unit': 'Hz'}}}


def other(name, joints=(JOINT,), behind=5.0, std=2.0):
    """Return an alternative as report.json has it."""
    return {'effect': name, 'joints': list(joints), 'behind': behind, 'std': std}


def result(hidden, findings, kind='single', strength=2.0, torque=(2.0, 1.0), mass=(0.4, 0.2),
           **more):
    """Return the result of hidden effects [(name, joints)], errors over those without of 1."""
    return {'label': f'{kind} {hidden}', 'kind': kind, 'plant': PLANT,
            'effects': [{'name': name, 'strength': strength, 'joints': list(joints)}
                        for name, joints in hidden],
            'findings': findings, 'parameters': [], 'seconds': 100.0,
            'torque': {'before': [torque[0], 1.0], 'after': [torque[1], 1.0],
                       'without': [1.0, 1.0]},
            'seen': {'joints': [JOINT, OTHER], 'share': [1.0, 0.1], 'known': [0.5, 0.0],
                     'before': [torque[0], 0.0], 'after': [torque[1], 0.0]},
            'mass': {key: {'3 s': [value, -value], 'end': [0.5 * value]} for key, value in
                     zip(('before', 'after', 'without'), (*mass, 0.2))}, **more}


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


# Scores.

def results():
    """Return a small suite with known figures."""
    delay = [('time_delay', (JOINT,))]
    figure = [{'effect': 'time_delay', 'parameter': 'delay', 'truth': 0.02, 'estimate': 0.015,
               'std': 0.002}]
    return [
        result(delay, [finding('time_delay')], torque=(4.0, 1.1), parameters=figure),
        result(delay, [finding('backlash')], torque=(3.0, 2.0), mass=(0.8, 0.4)),
        result(delay, [], strength=0.5),
        result([('time_delay', (JOINT,)), ('torque_scale', (OTHER,))], [finding('time_delay')],
               'pair'),
        result([], [finding('torque_offset'), finding('backlash', verdict='suspected')], 'clean'),
        result([('swinging_load', ())], [finding('unknown', variables=['time'], frequency=1.0)],
               'outside', parameters=SWING),
        {'label': 'f', 'kind': 'single', 'plant': PLANT, 'failed': 'ValueError: broke',
         'effects': [{'name': 'cable_drag', 'strength': 5.0, 'joints': []}]},
        {'label': 's', 'kind': 'single', 'plant': PLANT, 'skipped': 'not so strong',
         'effects': [{'name': 'backlash', 'strength': 5.0, 'joints': []}]}]


def test_rows_are_exact():
    rows = {(row['name'], row['strength']): row for row in effect_rows(results())}
    assert set(rows) == {('time_delay', 2.0), ('time_delay', 0.5), ('swinging_load', 2.0),
                         ('cable_drag', 5.0)}
    row = rows['time_delay', 2.0]
    assert row['outcomes'] == {'found': 1, 'confused': 1} and row['false'] == {'backlash': 1}
    assert (row['joint_right'], row['joints'], row['cases']) == (2, 2, 2)
    assert row['torque'] == pytest.approx({'before': 3.5, 'after': 1.55})
    rms = np.sqrt((0.2 ** 2 + 0.4 ** 2) / 2)
    assert row['mass']['after']['3 s'] == pytest.approx(rms / 0.2)
    assert row['mass_rmse']['after']['end'] == pytest.approx(0.5 * rms)
    # The second case was not found: its figures are nobody's.
    (figure,) = row['parameters'].values()
    assert figure == {'error': pytest.approx(0.25), 'found': 1, 'stated': 1, 'within': 0}
    assert rows['cable_drag', 5.0]['outcomes'] == {'missed': 1}
    assert rows['cable_drag', 5.0]['torque'] is None


def test_totals_and_goals_are_judged_on_the_figures():
    total = totals(results())
    assert total['single'] == [3, 1] and total['pairs'] == [1, 0]
    assert total['outside'] == [1, 1] and total['clean'] == [1, 1]
    assert confusions(results()) == {'time_delay': {'backlash': 1}}
    assert pair_rows(results())[0]['outcomes'] == ['found', 'missed']
    rows = {what: (value, good) for what, _, value, good in verdicts(total)}
    assert rows['right effect and joint, one effect, strength 2 and 5'] \
        == ('33.3 % (1 of 3; 95 % interval 6.1 to 79.2 %)', False)
    assert rows['the same, and nothing false confirmed beside'][1] is False
    assert rows['confirmed on clean plants'] == ('1 on 1, too few to tell', False)
    assert [verdicts({**total, 'clean': [20, false]})[5][3] for false in (1, 2)] == [True, False]
    assert rows['both of a pair right'][1] is False
    assert [good for what, (_, good) in rows.items() if what.startswith('torque')] == [False]
    assert rows['the same within 1.15 x of what is left where the effect is known'][1] is False
    assert rows['seconds per diagnosis, median and longest'] == ('100, 100', True)
    slow = totals([result([], [], 'clean', seconds=181.0)] * 2)
    assert not verdicts(slow)[-1][3]


def test_figures_are_held_against_what_is_stated_of_them():
    delay, truth = [('time_delay', (JOINT,))], {'effect': 'time_delay', 'parameter': 'delay',
                                                'truth': 0.02}
    cases_ = [result(delay, [finding('time_delay')], parameters=[
        {**truth, 'estimate': 0.025, 'std': std}]) for std in (0.0024, 0.0026, None)]
    (row,) = effect_rows(cases_)
    assert row['parameters']['delay'] == {'error': pytest.approx(0.25), 'found': 3, 'stated': 2,
                                          'within': 1}


@pytest.mark.parametrize('count, cases_, low, high', [
    (9, 12, 0.4677, 0.9111), (0, 20, 0.0, 0.1611), (4, 4, 0.5101, 1.0)])
def test_intervals_of_shares_are_wilsons(count, cases_, low, high):
    assert wilson(count, cases_) == pytest.approx((low, high), abs=1e-4)


def test_torque_and_mass_goals_hold_where_every_case_is_within():
    delay = [('time_delay', (JOINT,))]
    near = [result(delay, [], torque=(2.0, 1.1)) for _ in range(9)]
    far = result(delay, [], torque=(2.0, 1.2), mass=(0.4, 0.31))
    for cases_, good in ((near, True), ([*near, far], False)):
        rows = [r for r in verdicts(totals(cases_)) if r[1] == 'every case']
        assert [row[3] for row in rows] == [good, False, good] and len(rows) == 3
    assert [row[2] for row in rows[::2]] == [
        '90.0 % (9 of 10; 95 % interval 59.6 to 98.2 %); median 1.10 x, worst 1.20 x; median '
        'before 2.00 x',
        '90.0 % (9 of 10; 95 % interval 59.6 to 98.2 %); median 1.00 x, worst 1.55 x; median '
        'before 2.00 x']
    (case,) = beyond(totals(cases_), 'torque', 1.15)
    assert case['torque'] == pytest.approx({'before': 2.0, 'after': 1.2})
    # The joint that hardly a row of is judged has no say.
    assert case['seen'] == pytest.approx({'before': 4.0, 'after': 2.4})
    few = result(delay, [], torque=(2.0, 0.5))
    assert seen_ratio(few, 'after') == pytest.approx(1.0)
    for share in ([0.1, 1.0], [0.0, 0.0]):
        few['seen']['share'] = share
        assert np.isnan(seen_ratio(few, 'after'))
    assert not [good for what, *_, good in verdicts(totals([few])) if 'is known' in what][0]
    assert 'judged in 1 of 1 cases' in effects_markdown([few], '', '')
    # A ratio that is no number is not within.
    assert beyond({'ratios': [{'torque': {'after': float('nan')}}]}, 'torque', 1.15)


def test_a_run_broken_off_names_what_has_no_case_yet():
    planned = [EffectCase('single', plant, (Hidden(name, strength),))
               for name in ('cable_drag', 'backlash') for strength in (0.5, 2.0, 5.0)
               for plant in (1, 2)]
    there = [{**result([('cable_drag', (JOINT,))], []), 'label': 'single-cable_drag_2-2'},
             {**result([('backlash', ())], [], strength=0.5), 'label': 'single-backlash_0.5-1'}]
    assert not_tried(there, planned) == [('cable_drag', [5.0]), ('backlash', [2.0, 5.0])]
    page = effects_markdown(there, '', '', planned)
    assert '**Broken off: 2 of 12 cases.**' in page and '`backlash` (2, 5)' in page
    assert 'Broken off' not in effects_markdown(there, '', '', planned[:2])


def test_the_page_shows_what_was_measured():
    page = effects_markdown(results(), 'hand_load benchmark --suite effects', 'abc1234')
    assert to_markdown(blocks_of(page)) == page
    assert 'hand_load benchmark --suite effects' in page and 'abc1234' in page
    assert '| `time_delay` | 2 | 1 of 2 | found 1, confused 1 | 2 of 2 | backlash 1 |' in page
    assert '| `time_delay` | 2 | delay | 25 | 0 of 1 | 0 |' in page
    assert '| `swinging_load` | 2 | frequency | 0 | - | 1 |' in page
    assert 'deviations: 0.0 % (0 of 1; ' in page and '; 1 of 2 have none' in page
    assert 's: not so strong' in page and 'f: ValueError: broke' in page
    # Beyond the goals: the second case, in torque and in mass.
    assert f'| `time_delay` | 2 | {JOINT} | {PLANT} | confused | 3.00 | 2.00 | 4.00 |' in page
    assert f'| `time_delay` | 2 | {JOINT} | {PLANT} | confused | 400.0 | 200.0 | 100.0 | 2.00 |' \
        in page


# Runs.

def identified_again(model, evidence, test):
    """Diagnose without choosing: the default effects once more, on the changed arm."""
    n = model.robot.n
    found = Finding('viscous_friction', (model.robot.joints[1],), {'coefficient': (1.0, 0.1, 'x')},
                    np.zeros(n), Evidence(9.0, 1.0, 3.0, 20, 40, 1.0), (), '', True, CONFIRMED)
    zero = np.zeros(n)
    diagnosis = Diagnosis(model.robot.name, tuple(model.robot.joints), zero, zero, zero, (found,),
                          zero)
    return diagnosis, identify(model.robot, evidence), 1.0


@pytest.fixture
def small(tmp_path, monkeypatch):
    """Return the path of a small arm's robot file; recordings are brief, no diagnosis is made."""
    brief = (('excite', 20.0, 12.0), ('pick_place', 30.0, 8.0))
    monkeypatch.setattr(cases, 'IDENTIFICATION', brief)
    monkeypatch.setattr(cases, 'DURATION', 5.0)
    monkeypatch.setattr(effect_recordings, 'DIAGNOSED', brief)
    monkeypatch.setattr(effect_recordings, 'TESTED', (('excite', 25.0, 6.0),))
    monkeypatch.setattr(effect_recordings, 'LOADED', 1)
    monkeypatch.setattr(effect_measure, 'diagnosis_of', identified_again)
    path = tmp_path / 'arm.yaml'
    path.write_text(yaml.safe_dump(four_axes().file.content))
    return path


def test_a_small_case_from_plant_to_result(small, tmp_path, monkeypatch):
    case = EffectCase('single', PLANT, (Hidden('viscous_friction', 5.0, (1,)),))
    (found,) = effect_run.run_cases([case], small, tmp_path / 'raw', workers=0)
    assert [p.name for p in (tmp_path / 'raw').iterdir()] == [f'{case.label}.json']
    assert judge(found)[0][0]['outcome'] == 'found'
    (figure,) = found['parameters']
    assert figure['estimate'] == pytest.approx(figure['truth'], rel=0.2)
    # identified_again states that of it.
    assert figure['std'] == 0.1
    torque = {key: np.array(value) for key, value in found['torque'].items()}
    assert torque['before'][1] > 2.0 * torque['without'][1]
    assert torque['after'][1] < 1.5 * torque['without'][1]
    seen = {key: np.array(value) for key, value in found['seen'].items()}
    assert seen['before'][1] > 2.0 * seen['known'][1]
    np.testing.assert_allclose(seen['known'], torque['without'], rtol=0.1)
    assert set(found['mass']) == {'before', 'after', 'without'}
    assert all(len(errors) == 1 for kind in found['mass'].values() for errors in kind.values())
    # What is there is read, not made again.
    monkeypatch.setattr(effect_run, 'case_result', None)
    assert effect_run.run_cases([case], small, tmp_path / 'raw', workers=0) == [found]
    assert 'viscous_friction' in effects_markdown([found], '', '')


def test_a_small_case_of_the_whole_arm(small, tmp_path):
    case = EffectCase('single', PLANT, (Hidden('load_change', 5.0),))
    (found,) = effect_run.run_cases([case], small, tmp_path / 'raw', workers=0)
    assert judge(found)[0][0]['outcome'] == 'confused'
    (figure,) = found['parameters']
    assert figure['truth'] > 0.01 and figure['estimate'] is None and figure['std'] is None
    assert '| `load_change` | 5 | 0 of 1 |' in effects_markdown([found], '', '')


def test_what_cannot_be_made_is_skipped_with_its_reason(small, tmp_path):
    case = EffectCase('single', PLANT, (
        Hidden('temperature_dependent_viscous_friction', 500.0, (0, 1)),))
    (found,) = effect_run.run_cases([case], small, tmp_path / 'raw', workers=0)
    assert 'so strong' in found['skipped'] and not effect_rows([found])


def test_a_broken_case_is_told_and_tried_again(tmp_path):
    case = EffectCase('clean', PLANT)
    (found,) = effect_run.run_cases([case], 'no such arm', tmp_path / 'raw', 1, lambda text: None)
    assert found['failed'].startswith('ConfigurationError: ') and found['label'] == case.label
    assert not list((tmp_path / 'raw').iterdir())


def test_a_suite_writes_its_pages_and_resumes(tmp_path, monkeypatch):
    """Cases measured before are read, not measured again."""
    chosen = suite_cases(ur10e())[:3]
    monkeypatch.setattr(effect_run, 'suite_cases', lambda *_: chosen)
    monkeypatch.setattr(effect_run, 'commit_now', lambda: 'abc')
    raw, told = tmp_path / 'raw', []
    raw.mkdir()
    for case in chosen:
        hidden = [(h.name, (JOINT,) if h.joints else ()) for h in case.hidden]
        (raw / f'{case.label}.json').write_text(json.dumps(result(hidden, [], case.kind)))
    page = effect_run.run_effects('ur10e', tmp_path, 'the command', told.append)
    assert 'the command' in page and told[0] == '3 of 3 are there'
    assert (tmp_path / 'README.md').read_text() == page
    html = (tmp_path / 'index.html').read_text()
    assert html.count('<table>') == page.count('| --- |\n') and '<h1>Undeclared effects' in html
    assert '| ' not in html.split('<body>')[1]
    assert json.loads((tmp_path / 'scores.json').read_text())['suite'] == 'effects'
    monkeypatch.setattr(effect_run, 'commit_now', lambda: 'def')
    with pytest.raises(ConfigurationError, match='another suite, robot, artefact or commit'):
        effect_run.run_effects('ur10e', tmp_path, 'the command', told.append)


def test_a_suite_broken_off_writes_the_page_of_what_is_there(tmp_path, monkeypatch):
    chosen = suite_cases(ur10e())[:3]
    monkeypatch.setattr(effect_run, 'suite_cases', lambda *_: chosen)
    (tmp_path / 'raw').mkdir()
    (tmp_path / 'raw' / f'{chosen[0].label}.json').write_text(json.dumps(
        {**result([(h.name, (JOINT,)) for h in chosen[0].hidden], [], chosen[0].kind),
         'label': chosen[0].label}))

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(effect_run, 'run_cases', interrupted)
    with pytest.raises(KeyboardInterrupt):
        effect_run.run_effects('ur10e', tmp_path, 'the command', print)
    assert 'Broken off: 1 of 3' in (tmp_path / 'README.md').read_text()


def test_the_command_chooses_the_suite(tmp_path, monkeypatch, capsys):
    called = []
    monkeypatch.setattr(effect_run, 'run_effects', lambda *args: called.append(args) or 'page')
    assert cli.main(['benchmark', '--suite', 'effects', '--out', str(tmp_path)]) == 0
    assert called[0][:2] == ('ur10e', str(tmp_path)) and 'page' in capsys.readouterr().out
    assert called[0][-2:] == (None, False)
    assert cli.main(['benchmark', '--suite', 'effects', '--development', '--workers', '1', '--out',
                     str(tmp_path)]) == 0
    assert called[1][-2:] == (1, True)
    for option in ('--learned', '--methods', '--cases'):
        assert cli.main(['benchmark', '--suite', 'effects', option, '7', '--out', 'y']) == 2
        assert option in capsys.readouterr().err
