"""Limits: what is refused, and what recordings cannot tell is said."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import four_axes
import numpy as np
import pytest
from residual_helpers import cable, cut, declared_model, noise_of, on, recorded, viscous

from hand_load_estimator.errors import RecordingError
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.doubts.limits import (refuse_the_useless, slow_joint_states,
                                                        still_joints, too_little_gained,
                                                        true_delay, warmed_joints)
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.hypotheses import hypotheses


def moving(evidence, joint=None, **changes):
    """Return Evidence with arrays of its Motion replaced, at one joint or at all."""
    new = {}
    for name, value in changes.items():
        array = getattr(evidence.motion, name).copy()
        array[:, slice(None) if joint is None else joint] = value
        new[name] = array
    return replace(evidence, motion=replace(evidence.motion, **new))


def test_what_nearly_gains_enough_is_told_where_structure_is_left():
    robot = four_axes()
    nearly = [SimpleNamespace(name=name, joints=[j], gain=gain) for name, j, gain in (
        ('gravity_spring', 1, 21.0), ('cable_drag', 1, 20.0), ('backlash', 2, 15.0),
        ('time_delay', 3, 30.0))]
    (said,) = too_little_gained(robot, nearly, 32.0, (0, 1, 2))
    assert said == (f'cannot tell whether {robot.joints[1]} has gravity_spring because its gain '
                    'of 21 nats is less than the 32 needed; record more motion')
    assert not too_little_gained(robot, nearly, 32.0, ())


def test_too_short_and_resting_recordings_are_refused():
    model, (first, *_) = declared_model(), recorded()
    refuse_the_useless(model, [first])
    with pytest.raises(RecordingError, match=r'run 0.*2\.0 s.*4\.8 s'):
        refuse_the_useless(model, [cut(first, slice(100))])
    with pytest.raises(RecordingError, match='no joint moves'):
        refuse_the_useless(model, [moving(first, v=1e-3)])


def test_torque_of_another_arm_is_refused():
    """Among good recordings too; friction and payload of its own do not make another arm."""
    model, runs = declared_model(), recorded()
    refuse_the_useless(model, runs)
    refuse_the_useless(model, recorded(on(1, 8.0, viscous), on(2, 8.0, cable)))
    with pytest.raises(RecordingError, match='run 3.*explains less than half'):
        refuse_the_useless(model, [*runs[:3], replace(runs[3], torque=-runs[3].torque)])


def test_neither_a_hard_push_nor_a_short_part_makes_another_arm():
    """A push of many times the arm's own torque; a part in which friction holds nearly all."""
    model, (run, *_) = declared_model(), recorded()
    rows = np.arange(len(run.torque)) < 0.06 * len(run.torque)
    pushed = run.torque + 20.0 * rows[:, None] * run.torque.std(axis=0)
    refuse_the_useless(model, [replace(run, torque=pushed)])
    start, rest = cut(replace(run, torque=-run.torque), rows), cut(run, ~rows)
    refuse_the_useless(model, [start, rest])
    with pytest.raises(RecordingError, match='alone.*(explains less than half|looks loaded)'):
        refuse_the_useless(model, [replace(start, name='alone'), rest])


@pytest.mark.parametrize('celsius, warmed, words', [
    ((15.0, 35.0), (0, 1, 2, 3), None), ((25.0, 25.0), (), 'only 0.0 K'),
    ((25.0, 27.9), (), 'only 2.9 K'), ((np.nan, np.nan), (), 'none was recorded')])
def test_temperatures_tell_when_they_change(celsius, warmed, words):
    model = declared_model()
    evidence = [moving(e, temperature=celsius[k % 2]) for k, e in enumerate(recorded())]
    found, sentences = warmed_joints(model, evidence)
    assert tuple(found) == warmed
    assert [words in s and s.startswith('cannot tell') for s in sentences] \
        == ([True] if words else [])


def test_temperatures_in_another_unit_are_said_to_be_refused():
    model = declared_model()
    blind = [replace(moving(e, temperature=np.nan), rejected={'implausible_temperature': 30})
             for e in recorded()]
    (said,) = warmed_joints(model, blind)[1]
    assert '120 readings are no temperature of a joint in degC (kelvin, or' in said


def test_a_recording_without_temperatures_is_named_where_others_tell_of_them():
    model, runs = declared_model(), recorded()
    blind = moving(runs[0], temperature=np.nan)
    _, (said,) = warmed_joints(model, [blind, *runs[1:]])
    assert 'what of run 0 is of temperature' in said
    # Others of one temperature tell nothing of what depends on it.
    _, (said,) = warmed_joints(model, [blind, runs[2], replace(runs[2], name='again')])
    assert 'differ by only 0.0 K' in said


def test_a_joint_that_does_not_warm_is_named():
    model = declared_model()
    evidence = [moving(e, 1, temperature=25.0) for e in recorded()]
    found, sentences = warmed_joints(model, evidence)
    assert tuple(found) == (0, 2, 3)
    assert len(sentences) == 1 and model.robot.joints[1] in sentences[0]


def test_a_joint_that_never_moves_is_named():
    model = declared_model()
    evidence = [moving(e, 2, v=0.0) for e in recorded()]
    assert list(still_joints(model, evidence)) == [2]
    assert 'j2' in still_joints(model, evidence)[2]
    assert not still_joints(model, [*evidence, recorded()[0]])


def test_a_joint_without_temperatures_is_told_so_beside_one_that_warms():
    model = declared_model()
    runs = [moving(run, 2, temperature=np.nan) for run in recorded()]
    warmed, told = warmed_joints(model, runs)
    assert warmed == (0, 1, 3)
    assert told == [f'cannot tell effects of temperature of {model.robot.joints[2]} because none '
                    'was recorded']


@pytest.mark.parametrize('dt, slow, said', [
    (0.01, False, ''), (0.02, False, 'delays below 10 ms'), (0.04, True, 'delays, and little')])
def test_no_delay_is_sought_between_joint_states_that_come_too_rarely(dt, slow, said):
    """A message a row."""
    runs = [replace(run, motion=replace(
        run.motion, dt=np.full(len(run.torque), dt), messages=np.ones(len(run.torque), int)))
            for run in recorded()[:3]]
    told = slow_joint_states(runs)
    assert bool(told) == bool(said) and said in ''.join(told)
    assert not told or 'run 0, run 1, run 2' in told[0]
    model = declared_model()
    residual = find_residual(model, runs)
    names = {h.name for h in hypotheses(model, residual, residual.blocks(), ())}
    assert ('time_delay' in names) != slow and 'torque_scale' in names


@pytest.mark.parametrize('dt, seconds, true', [
    (0.01, 1e-4, True), (0.02, 0.008, False), (0.02, -0.008, False), (0.02, 0.012, True)])
def test_what_noise_of_accelerations_looks_like_is_no_delay(dt, seconds, true):
    assert true_delay(SimpleNamespace(longest_interval=dt), seconds) == true


def test_the_slowest_recording_tells_how_short_a_delay_may_be():
    quick, slow = (replace(run, motion=replace(run.motion, messages=np.full(
        len(run.torque), messages))) for run, messages in zip(recorded(), (10, 1)))
    residual = find_residual(declared_model(), [quick, cut(slow, slice(100))], cut=False)
    assert residual.interval == pytest.approx(0.002)
    assert residual.longest_interval == pytest.approx(0.02)


def test_a_noisier_recording_of_a_healthy_arm_has_no_effect():
    """Weights of the model's own noise would have made chance many nats."""
    model, rng = declared_model(), np.random.default_rng(5)
    runs = [replace(run, torque=run.torque + rng.normal(size=run.torque.shape)
                    * 4.0 * noise_of(model.robot)) for run in recorded()]
    diagnosis, _ = diagnose(model, runs)
    assert not diagnosis.findings
    said = [text for text in diagnosis.cannot_tell if 'as noisy as the model states' in text]
    assert len(said) == len(runs) and 'run 0' in said[0]
    assert (diagnosis.noise_floor > 2.0 * noise_of(model.robot)).all()
    residual = find_residual(model, recorded(), cut=False)
    assert residual.as_noisy_as(residual.residual, model.residuals.intensity) is residual
