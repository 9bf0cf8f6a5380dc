"""What a finding says of itself, also where the model was made from the recordings diagnosed."""

from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import alone, declared_model, diagnosed, on, recorded, ripple, viscous
from test_known_recordings import made_of, on_disk

from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.load import products_from_message
from hand_load_estimator.report.diagnosis_page import sentences
from hand_load_estimator.residual.add import better_model
from hand_load_estimator.residual.change_of import change_covariance
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED, Evidence, Finding, SUSPECTED
from hand_load_estimator.residual.findings import _derived, refuted
from hand_load_estimator.residual.measured.blocks import Score
from hand_load_estimator.residual.pictures import picture, travel as travel_since_reversal
from hand_load_estimator.residual.tracing.candidate import Candidate, Step
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis

JOINT = 1
EVIDENCE = Evidence(1.0, 1.0, 1.0, 1, 1, 1.0)


def toothed(run):
    """Friction that grows with the torque of the gear."""
    gear = np.array([run.robot.rigid_torque(*row) for row in zip(run.x.q, run.x.v, run.x.a)])
    return np.abs(gear) * run.x.z


@lru_cache(None)
def own():
    """Return (Diagnosis, identified model) of an arm whose model took load friction for others."""
    evidence = on_disk(recorded(on(JOINT, 12.0, toothed)))
    names = ('torque_offset', 'coulomb_friction', 'viscous_friction', 'link_inertia')
    model = identify(declared_model().robot, evidence[:-1], names)
    return diagnose(model, evidence[:-1], evidence[-1:])[0], model


def loaded_friction():
    found = {f.name: f for f in own()[0].findings}
    return found['load_dependent_friction']


def test_what_an_effect_explains_is_what_the_error_falls_by():
    diagnosis, _ = own()
    share = loaded_friction().explained[JOINT]
    fallen = 1.0 - (diagnosis.after[JOINT] / diagnosis.before[JOINT]) ** 2
    assert fallen > 0.3 and share == pytest.approx(fallen, abs=0.2)
    assert (np.delete(loaded_friction().explained, JOINT) < 0.05).all()


def test_the_picture_shows_friction_over_the_size_of_the_torque():
    (picture,) = loaded_friction().pictures
    assert 'size of gear torque' in picture.variable and (picture.x >= 0.0).all()
    # Means over what friction did at such a torque: rising, where it turns a little less so.
    assert np.corrcoef(picture.x, picture.curve)[0, 1] > 0.95
    assert picture.curve[-1] > 5.0 * picture.curve[0]
    # The points lie along the curve, whatever the old model had taken for what.
    off = np.sqrt(np.mean((picture.mean - picture.curve) ** 2))
    assert off < 0.15 * np.ptp(picture.curve)


def test_two_effects_of_a_joint_leave_each_other_their_own():
    diagnosis, _ = diagnose(declared_model(), recorded(on(2, 3.0, ripple), on(2, 2.0, viscous)))
    found = {f.name: f.explained[2] for f in diagnosis.findings}
    # Of noise 1, 9 and 4 of variance: each beside the other.
    assert found['torque_ripple'] == pytest.approx(0.9, abs=0.04)
    assert found['viscous_friction'] == pytest.approx(0.8, abs=0.06)


def test_a_dip_at_reversals_is_drawn_over_a_few_travels():
    travel, count = 9e-4, 20000
    way = np.where(np.arange(count) // 1000 % 2, -1.0, 1.0)
    q = np.cumsum(way * np.random.default_rng(0).uniform(0.0, 2e-4, count))[:, None]
    travelled = travel_since_reversal(q[:, 0])
    columns = -np.sign(travelled) * np.exp(-np.abs(travelled) / travel)
    hypothesis = Hypothesis('presliding_hysteresis', 0, {0: columns[:, None]}, np.ones(1),
                            {'presliding_distance': travel})
    score = Score(1.0, 1.0, np.ones(1), np.ones(1), 1e-4 * np.eye(1), {0: 1.0})
    residual = SimpleNamespace(x=SimpleNamespace(q=q), moving=np.ones((count, 1), bool))
    drawn = picture(declared_model().robot, residual, columns, hypothesis, score, 0)
    assert np.abs(travelled).max() > 80.0 * travel and np.abs(drawn.x).max() < 5.0 * travel
    assert len(drawn.x) > 8 and np.ptp(drawn.curve) > 1.5


def finding(joints, explained):
    chance = Evidence(9.0, 1.0, 1.0, 1, 1, 1.0)
    return Finding('torque_ripple', joints, {}, np.array(explained), chance, (), '', False,
                   CONFIRMED)


def as_before(n, without=1.0, beside=1.5):
    """Return what tells of any finding that without it errors were as before."""
    return lambda k: (np.full(n, without), np.full(n, beside))


@pytest.mark.parametrize('joints, explained, verdict', [
    (('elbow',), [0.0, 0.0], SUSPECTED), (('elbow',), [0.9, 0.1], SUSPECTED),
    (('pan',), [0.0, 0.0], CONFIRMED), (('pan', 'elbow'), [0.1, 0.4], SUSPECTED)])
def test_what_made_its_own_joint_worse_is_suspected(joints, explained, verdict):
    """An effect that explains nothing is not taken for the first joint's."""
    (found,), told = refuted((finding(joints, explained),), ('pan', 'elbow'),
                             np.array([1.0, 1.0]), np.array([0.5, 1.5]), as_before(2))
    assert found.verdict == verdict
    if verdict == SUSPECTED:
        assert len(told) == 1 and 'only suspected' in told[0]
    else:
        assert len(told) == 1 and 'nothing confirmed acts there' in told[0]


def test_a_link_found_changed_may_change_in_a_model_of_the_same_recordings():
    """Held as tightly as before it would stay as it was, and the finding say nothing."""
    evidence = on_disk(recorded())[:2]
    old = made_of(replace(declared_model(), links_declared=True), evidence)
    where = slice(20, 30)
    hypothesis = Hypothesis('link_inertia', 2, {}, np.ones(10))
    step = Step(Candidate('link_inertia', ((hypothesis, None),), 9.0, 1.0, np.ones(1)), (), None,
                1.0)
    same, freed = (np.sqrt(np.diag(better_model(old, steps, evidence).covariance))
                   for steps in ((), (step,)))
    assert (freed[where] > 1.5 * same[where]).any()
    np.testing.assert_allclose(np.delete(freed, np.arange(40)), np.delete(same, np.arange(40)),
                               rtol=0.5)


def test_what_makes_its_joint_worse_where_nothing_was_fitted_is_suspected():
    def found(name, joint, verdict='confirmed', recording=''):
        explained = np.eye(3)[joint]
        return Finding(name, (f'j{joint}',), {}, explained, EVIDENCE, (), '', False, verdict,
                       recording=recording)
    given = (found('cable_drag', 0), found('backlash', 1), found('backlash', 1, 'suspected'),
             found('external_contact', 1, recording='run'), found('unknown', 1),
             found('backlash', 2))
    kept, told = refuted(given, ('j0', 'j1', 'j2'), np.array([1.0, 1.0, np.nan]),
                         np.array([0.5, 1.2, np.nan]), as_before(3))
    assert [f.verdict for f in kept] == ['confirmed', 'suspected', 'suspected', 'confirmed',
                                         'confirmed', 'confirmed']
    assert len(told) == 1 and told[0].startswith('j1: backlash') and '1.2 Nm' in told[0]


@pytest.mark.parametrize('without, verdict', [
    (1.45, SUSPECTED), (1.48, CONFIRMED), (np.nan, SUSPECTED)])
def test_what_would_be_as_bad_without_an_effect_is_not_its_fault(without, verdict):
    asked = []

    def of(k):
        asked.append(k)
        return as_before(2, without)(k)
    given = (finding(('pan',), [0.9, 0.0]), finding(('elbow',), [0.0, 0.9]))
    kept, told = refuted(given, ('pan', 'elbow'), np.array([1.0, 1.0]), np.array([0.5, 1.5]), of)
    assert [f.verdict for f in kept] == [CONFIRMED, verdict] and asked == [1]
    assert told[0].startswith('elbow: ') and (' Nm without it)' in told[0]) == (
        verdict == SUSPECTED)


def test_a_joint_that_got_worse_though_nothing_acts_there_is_told():
    given = (finding(('pan',), [0.9, 0.0]),)
    kept, told = refuted(given, ('pan', 'elbow'), np.array([1.0, 1.0]), np.array([0.5, 1.03]),
                         as_before(2))
    assert kept == given and len(told) == 1
    assert told[0].startswith('elbow: the error') and 'from 1 to 1.03 Nm' in told[0]
    assert refuted(given, ('pan', 'elbow'), np.array([1.0, 1.0]), np.array([0.5, 1.01]),
                   as_before(2))[1] == ()


def test_one_cause_of_several_joints_makes_none_of_them_worse():
    given = (replace(finding(('pan', 'elbow'), [0.9, 0.1]), name='time_delay'),)
    (kept,), (told,) = refuted(given, ('pan', 'elbow'), np.array([1.0, 1.0]),
                               np.array([0.5, 1.2]), as_before(2))
    assert kept.verdict == SUSPECTED and told.startswith('elbow: time_delay is only suspected')


def test_a_joint_that_an_effect_of_several_made_worse_is_told():
    given = (finding(('pan', 'elbow'), [0.9, 0.1]),)
    kept, told = refuted(given, ('pan', 'elbow'), np.array([1.0, 1.0]), np.array([0.5, 1.7]),
                         as_before(2))
    assert kept == given and len(told) == 1
    assert told[0].startswith('elbow: ') and 'though torque_ripple was found there too' in told[0]


@lru_cache(None)
def doubtful():
    """Return (old figure, its deviation, true change, Finding) of a coefficient read too low."""
    model = declared_model(doubt=0.08)
    (where,) = (where.start for use, where in model.slices()
                if (use.name, use.joint) == ('viscous_friction', JOINT))
    true, std, mean = model.mean[where], np.sqrt(model.covariance[where, where]), model.mean.copy()
    mean[where] -= 1.5 * std
    more = alone(lambda run: 0.6 * true * run.x.v, JOINT)
    diagnosis, _ = diagnosed(more, model=replace(model, mean=mean))
    (found,) = (f for f in diagnosis.findings if f.name == 'viscous_friction')
    return std, 0.6 * true, found


def test_a_change_is_as_doubtful_as_both_figures():
    old, true, found = doubtful()
    (change, std, _), (_, new, _) = (found.parameters[name] for name in (
        'change_of_coefficient', 'coefficient'))
    assert std == pytest.approx(np.hypot(new, old), rel=1e-6) and std > 1.5 * new
    assert abs(change - true) < 2.0 * std
    # Of the new figure alone it would be far off.
    assert abs(change - true) > 4.0 * new


def test_nobody_knows_how_sure_a_change_is_that_the_model_s_own_recordings_show():
    model, places = declared_model(), np.arange(60, 63)
    more = replace(model, recordings=(*model.recordings, RecordingMark('another')))
    assert np.isnan(change_covariance(model, model, places, places)).all()
    renamed = replace(model, recordings=(RecordingMark('before', 'c0ffee'),))
    again = replace(model, recordings=(RecordingMark('renamed', 'c0ffee'),))
    assert np.isnan(change_covariance(renamed, again, places, places)).all()
    both = change_covariance(model, more, places, places)
    assert np.array_equal(both, 2.0 * model.covariance[60:63, 60:63])


def test_an_angle_of_a_spring_near_half_a_turn_has_an_interval():
    effect = EFFECTS['gravity_spring']
    for angle in (1.0, 3.1, -3.13):
        values = 10.0 * np.array([np.cos(angle), -np.sin(angle)])
        told = _derived(effect, {}, values, 0.01 * np.eye(2))
        mean, std, _ = told['angle']
        assert mean == pytest.approx(angle) and std == pytest.approx(0.01, rel=0.1)


def test_a_part_of_a_link_that_the_one_before_may_hold_is_named_with_both():
    """A mass on the axis of its joint is the same torque on either link."""
    products = products_from_message(np.array([0.3, 0.0, 0.1, *np.zeros(7)]))

    def heavier(run):
        links = np.zeros(40)
        links[20:30] = products
        return np.array([run.robot.link_regressor(*row) @ links
                         for row in zip(run.x.q, run.x.v, run.x.a)])

    diagnosis, _ = diagnosed(heavier)
    (found,) = (f for f in diagnosis.findings if f.verdict == CONFIRMED)
    links = {found.joints} | {a.joints for a in found.alternatives if a.name == 'link_inertia'}
    assert links == {('j1',), ('j2',)} and 'look at both' in found.advice
    assert 'or link inertia of' in sentences(diagnosis)[0]
