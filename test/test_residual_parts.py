"""Parts of the residual loop: ripple periods, limits, plain functions, the new model."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import four_axes
import numpy as np
from plant_helpers import ur10e
import pytest
from test_known_recordings import on_disk
from test_residual_trace import (cable, clean_runs, declared_model, noise_of, on, recorded, ripple,
                                 viscous)

from hand_load_estimator.effects.torque_ripple import waves
from hand_load_estimator.errors import RecordingError
from hand_load_estimator.motion import MotionFilter
from hand_load_estimator.residual.add import better_model, WIDER
from hand_load_estimator.residual.blocks import Blocks
from hand_load_estimator.residual.candidate import Candidate
from hand_load_estimator.residual.confusable import (advice, NO_KNOWN_MOTION, NO_MOTION,
                                                     PAIRS, partners, same_torque)
from hand_load_estimator.residual.diagnose import errors_of
from hand_load_estimator.residual.diagnosis import Finding
from hand_load_estimator.residual.findings import refuted, separating_motion
from hand_load_estimator.residual.hypotheses import hats, Hypothesis, with_effect
from hand_load_estimator.residual.limits import (refuse_the_useless, saturated_rows, still_joints,
                                                 too_little_gained, warmed_joints)
from hand_load_estimator.residual.ripple import CANDIDATES, likely_periods, NEAR, TURNS
from hand_load_estimator.robot import robot_from_content
from hand_load_estimator.torque_columns import effect_slices


# What is nearly named.

def test_what_nearly_gains_enough_is_told_where_structure_is_left():
    robot = four_axes()
    nearly = [SimpleNamespace(name=name, joints=[j], gain=gain) for name, j, gain in (
        ('gravity_spring', 1, 21.0), ('cable_drag', 1, 20.0), ('backlash', 2, 15.0),
        ('time_delay', 3, 30.0))]
    (said,) = too_little_gained(robot, nearly, 32.0, (0, 1, 2))
    assert said == (f'cannot tell whether {robot.joints[1]} has gravity_spring because its gain '
                    'of 21 nats is less than the 32 needed; record more motion')
    assert not too_little_gained(robot, nearly, 32.0, ())


# Ripple.

def wave(q, v, periods, phase):
    sine, cosine = waves(q, v, periods)
    return np.cos(phase) * sine + np.sin(phase) * cosine


@pytest.mark.parametrize('periods', [20.0, 60.0, 150.0])
@pytest.mark.parametrize('speed', [0.1, 0.5, 1.0])
def test_a_wave_is_what_comes_through_the_motion_filter(periods, speed):
    motion, phase = MotionFilter(1), 0.7
    found = []
    for k in range(1000):
        q = speed * k * 1e-3
        sample = motion.update(k * 1e-3, np.array([q]), np.array([speed]),
                               np.sin([periods * q + phase]))
        found += [sample] if sample is not None and not sample.fresh else []
    q, v, torque = (np.array([getattr(s, f)[0] for s in found]) for f in ('q', 'v', 'effort'))
    expected = wave(q, v, periods, phase)
    assert len(found) > 30
    np.testing.assert_allclose(torque, expected, atol=0.03 * np.abs(expected).max() + 1e-3)


def waving(periods, size, seed=0, count=4000):
    """Return q, v, residual, weights (N,) of a joint with a ripple in white noise of std 1."""
    rng, t = np.random.default_rng(seed), 0.02 * np.arange(count)
    q = 0.8 * np.sin(0.5 * t) + 0.5 * np.sin(0.23 * t + 1.0)
    v = 0.4 * np.cos(0.5 * t) + 0.115 * np.cos(0.23 * t + 1.0)
    residual = size * wave(q, v, periods, 0.3) + rng.normal(size=count)
    return q, v, residual, np.full(count, 1.0)


@pytest.mark.parametrize('periods', [11.3, 61.7, 152.0, 310.5])
def test_a_period_is_found_in_noise(periods):
    found, tried = likely_periods(*waving(periods, 0.5))
    # All that was looked at counts: the spectrum, and what refined each of its peaks.
    assert len(found) <= CANDIDATES and tried > 100 + len(found) * TURNS * NEAR
    assert found[0] == pytest.approx(periods, abs=0.25)


def test_a_period_found_in_noise_alone_gains_nothing():
    """Some period is always best; on blocks it was not fitted to it gains no more than chance."""
    for seed in range(4):
        q, v, residual, weights = waving(60.0, 0.0, seed)
        blocks = Blocks(residual[:, None], weights[:, None], [np.zeros((len(q), 0))],
                        np.arange(0, len(q), 200), np.arange(len(q) // 200) % 5)
        found, tried = likely_periods(q, v, residual, weights)
        assert len(found) == CANDIDATES
        for periods in found:
            columns = np.stack(waves(q, v, periods), axis=1)
            # The period itself is fitted to all blocks: the best of so many trials.
            assert blocks.evaluate({0: columns}).gain < 3.0 + np.log(tried)
    strong = waving(60.0, 0.5)
    blocks = Blocks(strong[2][:, None], strong[3][:, None], [np.zeros((len(strong[0]), 0))],
                    np.arange(0, 4000, 200), np.arange(20) % 5)
    found = likely_periods(*strong)[0][0]
    columns = np.stack(waves(*strong[:2], found), axis=1)
    assert blocks.evaluate({0: columns}).gain > 100.0


def test_a_joint_that_hardly_moves_has_no_period():
    q, v, residual, weights = waving(60.0, 3.0)
    found, tried = likely_periods(0.01 * q, 0.01 * v, residual, weights)
    assert len(found) == tried == 0


# Limits.

def moving(evidence, joint=None, **changes):
    """Return Evidence with arrays of its Motion replaced, at one joint or at all."""
    new = {}
    for name, value in changes.items():
        array = getattr(evidence.motion, name).copy()
        array[:, slice(None) if joint is None else joint] = value
        new[name] = array
    return replace(evidence, motion=replace(evidence.motion, **new))


def cut(evidence, rows):
    return replace(evidence, torque=evidence.torque[rows], motion=evidence.motion.part(rows))


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
    with pytest.raises(RecordingError, match='explains less than half'):
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


def test_plain_functions_of_what_has_come_to_rest_are_finite():
    """A filter forgets down to 1e-300, and no knots are that near to each other."""
    resting = np.concatenate([10.0 ** -np.linspace(3.0, 307.0, 400), -np.ones(200) * 1e-5])
    with np.errstate(all='raise', under='ignore'):
        columns = hats(resting, 16)
    assert np.isfinite(columns).all() and np.abs(columns).max(initial=0.0) <= 1.0
    assert not hats(np.zeros(100), 16).shape[1]


def efforts(torque, evidence):
    return replace(evidence, motion=replace(evidence.motion, effort=torque), torque=torque)


def test_rows_at_the_drives_limit_are_found():
    model, evidence = declared_model(), recorded()[0]
    rows, sentences = saturated_rows(model, [efforts(evidence.torque, evidence)])
    assert not rows.any() and not sentences
    limit = np.quantile(np.abs(evidence.torque[:, 1]), 0.8)
    clipped = evidence.torque.copy()
    clipped[:, 1] = np.clip(clipped[:, 1], -limit, limit)
    rows, sentences = saturated_rows(model, [efforts(clipped, evidence)])
    np.testing.assert_array_equal(rows[:, 1], np.abs(clipped[:, 1]) > 0.998 * limit)
    assert not rows[:, [0, 2, 3]].any()
    assert len(sentences) == 1 and 'j1' in sentences[0] and '20 %' in sentences[0]


def test_a_joint_at_rest_is_not_at_its_limit():
    """A held joint's effort is the same all the time and far from what the drive can do."""
    model, evidence = declared_model(), recorded()[0]
    torque = evidence.torque.copy()
    torque[:, 0] = 3.0
    rows, sentences = saturated_rows(model, [efforts(torque, evidence)])
    assert not rows.any() and not sentences


# Plain functions, pairs, rhythms.

def test_hats_make_any_smooth_function():
    values = np.random.default_rng(0).normal(size=2000)
    columns = hats(values, 32)
    inside = np.abs(values) < 2.0
    np.testing.assert_allclose(columns.sum(axis=1), 1.0)
    target = np.tanh(3.0 * values)
    fit, *_ = np.linalg.lstsq(columns, target, rcond=None)
    assert np.abs(columns @ fit - target)[inside].max() < 0.03
    assert hats(np.zeros(100), 32).shape == (100, 0)


def test_pairs_of_the_design_are_known_with_a_motion():
    for pair in (('gravity_spring', 'link_inertia'), ('gravity_spring', 'cable_drag'),
                 ('presliding_hysteresis', 'stribeck_friction'),
                 ('temperature_dependent_coulomb_friction',
                  'temperature_dependent_viscous_friction'), ('base_tilt', 'link_inertia')):
        assert pair[1] in partners(pair[0]) and pair[0] in partners(pair[1])
        assert len(advice(pair[0], [pair[1]])) > 20
        assert advice(*pair[:1], [pair[1]]) == advice(pair[1], [pair[0]])
    assert all(len(pair) == 2 for pair in PAIRS)


def test_advice_says_so_where_no_motion_is_known():
    assert advice('torque_ripple', []) == ''
    assert advice('coulomb_friction', ['base_tilt']) == f'{NO_KNOWN_MOTION} base_tilt'
    both = advice('cable_drag', ['gravity_spring', 'backlash'])
    assert both.startswith('move the joint over a whole turn') and both.endswith(' backlash')
    assert 'in several poses' in advice('cable_drag', ['base_tilt'])
    # Its own name on other joints is no effect to be told from.
    assert advice('cable_drag', ['cable_drag']) == ''


def test_effects_of_the_same_torque_are_told():
    rotor, other = np.random.default_rng(3).normal(size=(2, 100, 1))
    assert same_torque(rotor, rotor * [0.0, 2.0, -3.0])
    assert not same_torque(rotor, np.hstack([rotor, 1e-3 * other]))


@pytest.mark.parametrize('gravity, same', [([0.0, 0.0, -9.81], True), ([0.5, 0.0, -9.8], False)])
def test_a_rotor_and_the_first_link_of_an_upright_arm_are_one_to_recordings(gravity, same):
    robot, rng = robot_from_content({**ur10e().file.content, 'gravity': gravity}, 'arm'), \
        np.random.default_rng(4)
    motions = [rng.normal(size=(3, robot.n)) for _ in range(50)]
    links = np.array([robot.link_regressor(*qva) for qva in motions])
    acceleration = np.array([[a[0]] for _, _, a in motions])
    residual = SimpleNamespace(columns=links)
    rotor = Hypothesis('rotor_inertia', 0, {0: acceleration}, np.ones(1))
    chosen = Candidate('rotor_inertia', ((rotor, None),), 1.0, 1.0, np.ones(1))
    assert separating_motion(residual, chosen, ['link_inertia']).startswith(NO_MOTION) == same


def test_what_makes_its_joint_worse_where_nothing_was_fitted_is_suspected():
    def found(name, joint, verdict='confirmed', recording=''):
        explained = np.eye(3)[joint]
        return Finding(name, (f'j{joint}',), {}, explained, None, (), '', False, verdict,
                       recording=recording)
    given = (found('cable_drag', 0), found('backlash', 1), found('backlash', 1, 'suspected'),
             found('external_contact', 1, recording='run'), found('unknown', 1),
             found('backlash', 2))
    kept, told = refuted(given, ('j0', 'j1', 'j2'), np.array([1.0, 1.0, np.nan]),
                         np.array([0.5, 1.2, np.nan]))
    assert [f.verdict for f in kept] == ['confirmed', 'suspected', 'suspected', 'confirmed',
                                         'confirmed', 'confirmed']
    assert len(told) == 1 and told[0].startswith('j1: backlash') and '1.2 Nm' in told[0]


# The better model.

def step_of(name, joint, shape=None, alternatives=()):
    """Return a Step that says an effect was found."""
    hypothesis = Hypothesis(name, joint, {}, np.ones(1), shape or {})
    return SimpleNamespace(chosen=SimpleNamespace(parts=((hypothesis, None),)),
                           alternatives=[SimpleNamespace(name=other, joints=[place])
                                         for other, place in alternatives])


def parameter(model, name, joint):
    """Return (mean, std) of the first parameter of an effect."""
    for use, where in model.slices():
        if (use.name, use.joint) == (name, joint):
            return model.mean[where.start], np.sqrt(model.covariance[where.start, where.start])
    return None


def wrong(factor=1.5, doubt=1e-4):
    """Return a model that is sure of a wrong Coulomb level of joint 0."""
    model = declared_model(doubt)
    mean = model.mean.copy()
    for use, where in model.slices():
        if (use.name, use.joint) == ('coulomb_friction', 0):
            mean[where] *= factor
    return replace(model, mean=mean)


def test_new_recordings_leave_what_is_known_and_fill_in_what_is_new():
    """The old model is the prior: sure of a Coulomb level it keeps it, the ripple is estimated."""
    model, evidence = wrong(), recorded(on(2, 2.0, ripple))
    found = better_model(model, [step_of('torque_ripple', 2, {'periods': 23.4})], evidence)
    old, std = parameter(model, 'coulomb_friction', 0)
    new, after = parameter(found, 'coulomb_friction', 0)
    assert abs(new - old) < 4.0 * WIDER * std and after <= WIDER * std * 1.001
    size = 2.0 * np.sqrt(2.0) * noise_of(model.robot)[2]
    mean, std = parameter(found, 'torque_ripple', 2)
    assert mean == pytest.approx(size * np.cos(0.5), abs=4.0 * std + 0.02 * size)
    assert parameter(found, 'torque_ripple', 1) is None
    assert found.recording_names == [*model.recording_names, 'run 0', 'run 1', 'run 2', 'run 3']


def test_what_was_found_changed_is_free_again():
    model, evidence = wrong(), recorded()
    found = better_model(model, [step_of('coulomb_friction', 0)], evidence)
    truth, _ = parameter(declared_model(), 'coulomb_friction', 0)
    mean, std = parameter(found, 'coulomb_friction', 0)
    assert abs(mean - truth) < 4.0 * std + 0.01 * truth and std < 0.05 * truth


@pytest.mark.parametrize('alternatives, free', [
    ((), False), ((('coulomb_friction', 0),), True), ((('coulomb_friction', 1),), False),
    ((('rotor_inertia', 0),), False)])
def test_what_may_have_changed_instead_is_free_too(alternatives, free):
    """Nothing told friction of a loaded gear from Coulomb's: the fit of everything may."""
    model, evidence = wrong(), recorded()
    found = better_model(model, [step_of('load_dependent_friction', 0, None, alternatives)],
                         evidence)
    truth, _ = parameter(declared_model(), 'coulomb_friction', 0)
    mean, std = parameter(found, 'coulomb_friction', 0)
    assert (abs(mean - truth) < 4.0 * std + 0.02 * truth) == free


def test_its_own_recordings_are_not_counted_twice():
    """From the recordings it was made of, all is estimated anew, with the robot file's prior."""
    evidence = on_disk(recorded(on(2, 2.0, ripple)))
    model = replace(wrong(), recordings=tuple(e.mark for e in evidence))
    found = better_model(model, [step_of('torque_ripple', 2, {'periods': 23.4})], evidence)
    truth, _ = parameter(declared_model(), 'coulomb_friction', 0)
    mean, std = parameter(found, 'coulomb_friction', 0)
    assert abs(mean - truth) < 5.0 * std + 0.02 * truth
    assert std > 3.0 * parameter(model, 'coulomb_friction', 0)[1]
    assert found.recordings == model.recordings


@pytest.mark.parametrize('joint, effect, name, shape', [
    (2, ripple, 'torque_ripple', {'periods': 23.4}), (1, cable, 'cable_drag', {}),
    (3, viscous, 'viscous_friction', {})])
def test_the_better_model_is_better_on_what_it_has_not_seen(joint, effect, name, shape):
    model, evidence = declared_model(), recorded(on(joint, 2.0, effect))
    found = better_model(model, [step_of(name, joint, shape)], evidence[:3])
    before, after = (np.sqrt(np.nanmean(errors_of(m, evidence[3:]) ** 2, axis=0))
                     for m in (model, found))
    noise = noise_of(model.robot)
    assert after[joint] < 1.15 * noise[joint] < 0.8 * before[joint]
    assert (after < 1.02 * before).all() and (found.noise < 1.15 * noise).all()


def test_links_that_were_never_identified_are_not_said_to_be():
    model, evidence = declared_model(), recorded(on(2, 2.0, ripple))
    assert not model.links_declared
    found = better_model(model, [step_of('torque_ripple', 2, {'periods': 23.4})], evidence)
    assert not found.links_declared
    np.testing.assert_array_equal(found.mean[:40], model.mean[:40])


def test_presliding_enters_a_model_that_had_none():
    """A model of plain friction that turns over a travel gets the effect, and is better for it."""
    names = ('rotor_inertia', 'coulomb_friction', 'viscous_friction', 'torque_offset')
    model = declared_model(0.01, names)
    hypothesis = step_of('presliding_hysteresis', 1,
                         {'presliding_distance': 2e-3}).chosen.parts[0][0]
    uses = with_effect(model, hypothesis)
    assert [(u.joint, u.shape) for u in uses if u.name == 'presliding_hysteresis'] \
        == [(1, {'presliding_distance': 2e-3, 'power': np.inf})]
    # A model that has it keeps one, with the new travel.
    uses = with_effect(declared_model(), hypothesis)
    assert [u.shape['presliding_distance'] for u in uses if u.name == 'presliding_hysteresis'
            and u.joint == 1] == [2e-3]
    assert len(effect_slices(4, uses)) == len(declared_model().uses)


def test_recordings_are_as_the_tests_say():
    """The helper's own promise: an effect of so many times the noise, on its joint alone."""
    plain, more = (np.concatenate([e.torque for e in r]) for r in (
        recorded(), recorded(on(1, 2.0, cable))))
    rms = np.sqrt(np.mean((more - plain) ** 2, axis=0)) / noise_of(declared_model().robot)
    np.testing.assert_allclose(rms, [0.0, 2.0, 0.0, 0.0], atol=1e-9)
    assert len(clean_runs(16.0)) == 4
