"""Disturbances: a push or another load for a time is found with its size, times and joints."""

from dataclasses import replace
from functools import lru_cache

from core_helpers import block
import numpy as np
import pytest
from residual_helpers import (assert_repaired, cable, declared_model, diagnosed, noise_of, on,
                              recorded, ripple)

from hand_load_estimator.identification.evidence import recording_numbers
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.report.diagnosis_json import diagnosis_content
from hand_load_estimator.report.diagnosis_page import page
from hand_load_estimator.residual import explanation
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED, SUSPECTED
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.outside.disturbance import undisturbed
from hand_load_estimator.residual.outside.disturbance_findings import (disturbance_findings,
                                                                       findings_again)
from hand_load_estimator.residual.outside.outside import outside_of

FORCE, LOAD = np.array([12.0, -9.0, 15.0]), block(1.5)


@lru_cache(None)
def load_torque(load_mass, run):
    """Return the torque (N, n) of a block along a run."""
    robot, motion = declared_model().robot, recorded()[run].motion
    products = block(load_mass).to_products()
    return np.array([robot.load_regressor(*row) @ products
                     for row in zip(motion.q, motion.v, motion.a)])


def with_torque(evidence, run, rows, torque):
    """Return Evidence of all runs with a torque (N, n) [Nm] added in some rows of one of them."""
    changed = evidence[run].torque.copy()
    changed[rows] += torque[rows]
    return [*evidence[:run], replace(evidence[run], torque=changed), *evidence[run + 1:]]


def pushed(rows, force=FORCE, run=0, evidence=None):
    """Return Evidence of all runs; in some rows of one a force [N] pushes the hand."""
    robot, evidence = declared_model().robot, evidence or recorded()
    torque = np.array([-robot.hand_jacobian(q).T @ force for q in evidence[run].motion.q])
    return with_torque(evidence, run, rows, torque)


def loaded(rows, run=1, sign=1.0):
    """Return Evidence of all runs; in some rows of one the block hangs on the hand."""
    return with_torque(recorded(), run, rows, sign * load_torque(LOAD.mass, run))


def found_in(evidence):
    """Return (Outside, Findings)."""
    model, residual = declared_model(), find_residual(declared_model(), evidence)
    outside = outside_of(model, evidence, residual)
    return outside, disturbance_findings(model.robot, [e.name for e in evidence], residual,
                                         outside.found)


def assert_told(finding, **truths):
    """Hold parameters to their truth within their own 4 standard deviations."""
    for name, truth in truths.items():
        mean, std, _ = finding.parameters[name]
        assert abs(mean - truth) < 4.0 * std, (name, mean, std, truth)


@pytest.mark.parametrize('first, count', [(300, 15), (300, 40), (250, 250)])
def test_a_push_is_a_contact_with_its_force_and_time(first, count):
    """Of 0.3 s, 0.8 s and a third of the recording."""
    outside, (finding,) = found_in(pushed(slice(first, first + count)))
    assert finding.name == 'external_contact' and finding.verdict == CONFIRMED
    assert finding.recording == 'run 0' and finding.evidence.gain > finding.evidence.needed
    assert_told(finding, **dict(zip(('force_x', 'force_y', 'force_z'), FORCE)),
                force=np.linalg.norm(FORCE))
    assert finding.parameters['force_z'][1] < 5.0 and finding.parameters['force'][1] < 5.0
    start, end = (finding.parameters[name][0] for name in ('start', 'end'))
    assert start == pytest.approx(0.02 * first, abs=0.08)
    assert end == pytest.approx(0.02 * (first + count), abs=0.08)
    rows = outside.rows
    assert rows[first:first + count].all()
    assert not rows[:first - 12].any() and not rows[first + count + 12:].any()


def test_two_pushes_of_one_recording_are_two():
    once = pushed(slice(150, 180))
    twice = pushed(slice(500, 530), -FORCE, evidence=once)
    _, (first, second) = found_in(twice)
    assert_told(first, force_x=FORCE[0], force_y=FORCE[1], force_z=FORCE[2])
    assert_told(second, force_x=-FORCE[0], force_y=-FORCE[1], force_z=-FORCE[2])


@pytest.mark.parametrize('rows, known', [(slice(400, None), {'start'}),
                                         (slice(None, 400), {'end'}),
                                         (slice(300, 600), {'start', 'end'})])
def test_a_load_for_a_time_is_a_load_change(rows, known):
    _, (finding,) = found_in(loaded(rows))
    assert finding.name == 'load_change' and finding.recording == 'run 1'
    assert_told(finding, mass=LOAD.mass)
    assert finding.parameters['mass'][1] < 0.1
    assert known == {'start', 'end'} & set(finding.parameters)
    for name, row in (('start', rows.start), ('end', rows.stop)):
        if name in known:
            assert finding.parameters[name][0] == pytest.approx(0.02 * row, abs=0.08)
    if 'com_x' in finding.parameters:
        assert_told(finding, com_x=LOAD.com[0], com_y=LOAD.com[1], com_z=LOAD.com[2])


@pytest.mark.parametrize('rows', [slice(200, None), slice(100, 750), slice(300, 600)])
def test_a_light_load_is_no_push(rows):
    """It hardly resists acceleration: almost a constant force, but none that lasts as long."""
    robot, motion = declared_model().robot, recorded()[1].motion
    light = LoadParameters(0.5, np.zeros(3), np.zeros((3, 3))).to_products()
    torque = np.array([robot.load_regressor(*row) @ light
                       for row in zip(motion.q, motion.v, motion.a)])
    _, (finding,) = found_in(with_torque(recorded(), 1, rows, torque))
    others = [other.name for other in finding.alternatives]
    if rows.start == 300:
        assert {finding.name, *others} == {'load_change', 'external_contact'} and finding.advice
    else:
        assert finding.name == 'load_change'


def test_a_light_load_off_the_flange_is_a_load_not_a_push():
    """Its many parameters are no worse for being small ones: it turns with the hand."""
    robot, motion = declared_model().robot, recorded()[1].motion
    light = LoadParameters(0.25, np.array([0.0, 0.0, 0.03]), 1e-4 * np.eye(3)).to_products()
    torque = np.array([robot.load_regressor(*row) @ light
                       for row in zip(motion.q, motion.v, motion.a)])
    _, (finding,) = found_in(with_torque(recorded(), 1, slice(300, 600), torque))
    assert finding.name == 'load_change'


def test_only_a_declared_load_can_be_lost():
    lost = loaded(slice(400, None), sign=-1.0)
    assert not [f for f in found_in(lost)[1] if f.name == 'load_change']
    declared = [replace(e, load=LOAD) for e in lost]
    _, (finding,) = found_in(declared)
    assert finding.name == 'load_change'
    assert_told(finding, mass=-LOAD.mass)


def test_nothing_is_found_where_nothing_is():
    assert found_in(recorded())[1] == ()
    always = [pushed(slice(None), 0.5 * FORCE, run)[run] for run in range(4)]
    assert found_in(always)[1] == ()


def test_bursts_that_go_on_all_the_time_are_no_contacts():
    evidence = recorded()
    for start in range(50, 750, 90):
        for run in range(4):
            evidence = pushed(slice(start, start + 20), 0.4 * FORCE, run, evidence)
    assert found_in(evidence)[1] == ()


def test_joints_disturbed_on_their_own_are_no_contact():
    """No force at the hand and no load makes the same step in every joint of a moving arm."""
    torque = np.zeros_like(recorded()[0].torque) + 10.0 * noise_of(declared_model().robot)
    assert found_in(with_torque(recorded(), 0, slice(300, 500), torque))[1] == ()


def test_what_is_left_is_parts_without_the_rows():
    evidence, rows = recorded()[0], np.zeros(800, dtype=bool)
    rows[300:400] = True
    first, second = undisturbed(evidence, rows)
    assert len(first.torque) == 300 and len(second.torque) == 400
    assert first.name == second.name == evidence.name
    np.testing.assert_array_equal(second.motion.q, evidence.motion.q[400:])
    (last,) = undisturbed(evidence, rows, (0.5, 1.0))
    assert len(last.torque) == 350 and last.load.mass == 0.0


def test_parts_of_one_recording_are_one_recording():
    """A push near the start leaves a short and a long part; folds must not follow them."""
    first = recorded()[0]
    rows = np.zeros(len(first.torque), dtype=bool)
    rows[120:150] = rows[300:330] = True
    parts = undisturbed(first, rows)
    assert len(parts) == 3 and recording_numbers(parts) == [0, 0, 0]
    folds = find_residual(declared_model(), parts).folds
    # In time, and of about the same size.
    assert len(np.unique(folds)) == 6 and np.ptp(np.unique(folds, return_counts=True)[1]) <= 1
    assert recording_numbers([*parts, recorded()[1]]) == [0, 0, 0, 1]


def test_a_recording_too_short_to_tell_is_passed_over():
    first, *others = recorded()
    (short,) = undisturbed(first, np.arange(len(first.torque)) >= 60)
    assert found_in([short, *others])[1] == ()
    _, (finding,) = found_in([short, *pushed(slice(300, 340), run=1)[1:]])
    assert finding.recording == 'run 1'


def test_the_better_model_tells_what_acted_from_outside():
    twice = pushed(slice(500, 530), -FORCE, evidence=pushed(slice(150, 180)))
    model, names = declared_model(), [e.name for e in twice]
    residual, found = find_residual(model, twice), found_in(twice)[0].found
    shown = [(residual, one) for one in found]
    # As a model that explains the first of both would leave it, and half of the second.
    cleaner = pushed(slice(500, 530), -0.5 * FORCE)
    after = find_residual(model, cleaner), found_in(cleaner)[0].found
    findings, told = findings_again(model.robot, names, shown, after)
    assert [f.verdict for f in findings] == [SUSPECTED, CONFIRMED]
    assert_told(findings[1], **dict(zip(('force_x', 'force_y', 'force_z'), -0.5 * FORCE)))
    assert told == ('run 0: external_contact at 3.0 s is only suspected: it is not found again '
                    'with the model written',)
    # What only touches another is not the same.
    near = replace(found[1], first=found[0].stop - 1)
    findings, told = findings_again(model.robot, names, shown, (after[0], (near,)))
    assert [f.verdict for f in findings] == [SUSPECTED, CONFIRMED] and len(told) == 1
    # Of an arm that is held there is no evidence to compare.
    held = [(residual, replace(found[0], evidence=np.nan))]
    for others in ((), found):
        (finding,), told = findings_again(model.robot, names, held, (after[0], others))
        assert finding.verdict == CONFIRMED and told == ()
        assert np.isnan(finding.evidence.gain)


def test_what_is_found_in_rows_known_already_is_no_news():
    evidence = pushed(slice(500, 530), -FORCE, evidence=pushed(slice(150, 180)))
    residual = find_residual(declared_model(), evidence)
    outside, _ = found_in(evidence)
    first, second = outside.found
    assert outside.hidden(evidence, outside.found) == ()
    alone, _ = found_in(pushed(slice(150, 180)))
    assert alone.hidden(evidence, outside.found) == (second,)
    both = alone.joined(residual, (second,))
    assert [one.first for one in both.found] == [alone.found[0].first, second.first]
    np.testing.assert_array_equal(both.rows, outside.rows)
    assert both.shown[1] == (residual, second)
    # Of an arm that is held, standing.py tells.
    still = [replace(e, motion=replace(e.motion, q=np.zeros_like(e.motion.q))) for e in evidence]
    assert alone.hidden(still, outside.found) == ()


def test_a_push_that_a_strong_effect_hides_is_found_with_the_better_model():
    evidence = pushed(slice(300, 400), 0.5 * FORCE, evidence=recorded(on(2, 20.0, ripple)))
    assert found_in(evidence[:-1])[1] == ()
    diagnosis, better = diagnose(declared_model(), evidence[:-1], evidence[-1:])
    assert {f.name: f.verdict for f in diagnosis.findings} == {
        'torque_ripple': CONFIRMED, 'external_contact': CONFIRMED}
    push = diagnosis.findings[1]
    assert_told(push, **dict(zip(('force_x', 'force_y', 'force_z'), 0.5 * FORCE)))
    assert push.parameters['start'][0] == pytest.approx(6.0, abs=0.1)
    # It was left out of the model: as good as one of an arm that nobody pushed.
    _, alone = diagnosed(on(2, 20.0, ripple))
    std = np.sqrt(np.diag(alone.covariance))
    assert (np.abs(better.mean - alone.mean) <= std).all()
    # Nothing is left out of recordings given for the test.
    assert diagnosis.left_out == 0.0


def test_a_part_of_a_push_that_shows_as_a_whole_later_is_told_once():
    evidence = pushed(slice(300, 400))
    residual = find_residual(declared_model(), evidence)
    (whole,) = found_in(evidence)[0].found
    part = replace(whole, first=340, stop=360)
    known = replace(found_in(recorded())[0], shown=((residual, part),))
    assert known.hidden(evidence, (whole,)) == (whole,)
    both = known.joined(residual, (whole,))
    assert both.found == (whole,) and both.rows[300:400].all()
    # What only touches it stays.
    beside = replace(whole, first=390, stop=440)
    known = replace(known, shown=((residual, beside),))
    assert known.joined(residual, (whole,)).found == (whole, beside)


def test_what_could_not_be_left_out_is_said(monkeypatch):
    """Of a single recording too short without its push, and of a search that has ended."""
    short = pushed(slice(150, 340), 0.5 * FORCE, evidence=recorded(on(2, 20.0, ripple)))[0]
    short = replace(short, torque=short.torque[:500], motion=short.motion.part(slice(500)))
    long = pushed(slice(300, 400), 0.5 * FORCE, evidence=recorded(on(2, 20.0, ripple)))
    diagnosis, _ = diagnose(declared_model(), [short])
    (said,) = [text for text in diagnosis.cannot_tell if 'external_contact' in text]
    assert 's are left to diagnose, of 4.8 s' in said and 'run 0 at 3.0 s' in said
    assert [f.name for f in diagnosis.findings if f.recording] == []
    monkeypatch.setattr(explanation, 'AGAIN', 0)
    diagnosis, _ = diagnose(declared_model(), long[:-1], long[-1:])
    (said,) = [text for text in diagnosis.cannot_tell if 'external_contact' in text]
    assert 'run 0 at 6.0 s' in said and 'because the search ends' in said


def test_what_only_a_discarded_model_showed_is_only_suspected(monkeypatch):
    """As if nothing but the push had been the effect."""
    evidence = pushed(slice(300, 400), 0.5 * FORCE, evidence=recorded(on(2, 20.0, ripple)))
    explained, calls = explanation._explained, []

    def no_better_without_it(model, *arguments):
        calls.append(explained(model, *arguments))
        return replace(calls[-1], better=model) if len(calls) > 1 else calls[-1]
    monkeypatch.setattr(explanation, '_explained', no_better_without_it)
    found = explanation.explain(declared_model(), evidence, (), lambda text: None)
    assert len(calls) == 2 and len(found.outside.found) == 1
    (finding,), told = findings_again(declared_model().robot, [e.name for e in evidence],
                                      found.outside.shown, found.seen)
    assert finding.verdict == SUSPECTED and len(told) == 1


def test_a_push_in_what_is_kept_for_the_test_is_left_out_of_it():
    """It is searched for in whole recordings, with the better model, too."""
    evidence = pushed(slice(680, 740), 0.5 * FORCE, evidence=recorded(on(2, 20.0, ripple)))
    diagnosis, _ = diagnose(declared_model(), evidence)
    assert {f.name: f.verdict for f in diagnosis.findings} == {
        'torque_ripple': CONFIRMED, 'external_contact': CONFIRMED}
    assert diagnosis.left_out == pytest.approx(1.4, abs=0.1)
    assert_repaired(diagnosis, 2)


def test_a_part_of_a_strong_effect_that_looked_like_a_push_is_only_suspected():
    evidence = recorded(on(1, 40.0, cable))
    names = [f.name for f in found_in(evidence[:-1])[1]]
    assert names == ['external_contact']
    diagnosis, _ = diagnose(declared_model(), evidence[:-1], evidence[-1:])
    assert {f.name: f.verdict for f in diagnosis.findings} == {
        'cable_drag': CONFIRMED, 'external_contact': SUSPECTED}
    assert any('is not found again with the model written' in s for s in diagnosis.remains)


def test_a_push_beside_an_effect_that_is_found_stays_confirmed():
    evidence = pushed(slice(300, 400), evidence=recorded(on(2, 10.0, cable)))
    diagnosis, better = diagnose(declared_model(), evidence[:-1], evidence[-1:])
    assert better is not declared_model()
    told = {f.name: f.verdict for f in diagnosis.findings}
    assert told['external_contact'] == told['cable_drag'] == CONFIRMED


def test_a_diagnosis_names_them_and_leaves_them_out():
    evidence = loaded(slice(500, None))
    evidence = pushed(slice(300, 400), evidence=evidence)
    diagnosis, better = diagnose(declared_model(), evidence[:-1], evidence[-1:])
    names = [f.name for f in diagnosis.findings if f.verdict == CONFIRMED]
    assert names == ['external_contact', 'load_change']
    # Nothing of them went into the model.
    np.testing.assert_array_equal(better.mean, declared_model().mean)
    content = diagnosis_content(diagnosis)
    assert [e['recording'] for e in content['effects']] == ['run 0', 'run 1']
    assert {'mass', 'start'} <= set(content['effects'][1]['parameters'])
    text = page(diagnosis)
    assert 'It happened in <strong>run 1</strong>' in text and text.count('<img') >= 3


@pytest.mark.parametrize('rows, recordings, word', [
    (slice(500, None), 1, 'end'), (slice(0, 150), 1, 'begin'),
    (slice(300, 400), 1, None), (slice(500, None), 2, None)])
def test_what_never_ends_in_the_only_recording_may_be_the_arm(rows, recordings, word):
    """Only a recording from before or after tells that the arm itself is as it was."""
    evidence, model = pushed(rows)[:recordings], declared_model()
    residual, found = find_residual(model, evidence), found_in(evidence)[0].found
    (finding,), told = findings_again(model.robot, [e.name for e in evidence],
                                      [(residual, one) for one in found], (residual, found))
    assert finding.name == 'external_contact'
    assert finding.verdict == (SUSPECTED if word else CONFIRMED)
    assert len(told) == bool(word)
    assert all(f'does not {word} within the only recording' in text for text in told)
