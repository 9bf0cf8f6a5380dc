"""The trace: one hidden effect comes out as itself on its joint, two as two, none as none."""

from dataclasses import replace
from functools import lru_cache

from core_helpers import effect_uses, four_axes, true_parameters
import numpy as np
import pytest
from test_identification import waves

from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.evidence import Evidence
from hand_load_estimator.presliding import presliding_path
from hand_load_estimator.recording_mark import RecordingMark
from hand_load_estimator.residual.candidate import Candidate, significant, standard_error
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED, SUSPECTED, UNKNOWN
from hand_load_estimator.residual.find import find_residual
from hand_load_estimator.residual.hypotheses import (hypotheses, Hypothesis,
                                                        turned as turned_exactly)
from hand_load_estimator.residual.trace import Trace
from hand_load_estimator.torque_columns import (ColumnLayout, motion_input, presliding_distances,
                                                play_columns, torque_columns)
from hand_load_estimator.torque_model import Residuals, TorqueModel

DT = 0.02
RUNS, SECONDS = 4, 16.0


@lru_cache(None)
def declared_model(doubt=0.01, names=None):
    """Return the TorqueModel of the arm, right but for hidden effects; doubt: relative std."""
    robot = four_axes()
    uses = effect_uses(robot) if names is None else effect_uses(robot, names)
    mean = true_parameters(robot, uses)
    std = doubt * np.abs(mean)
    std[:10 * robot.n] = 0.0
    noise = noise_of(robot)
    return TorqueModel(robot, uses, False, mean, np.diag(std ** 2), Residuals(
        noise, noise ** 2 * DT, np.zeros((robot.n, 3))), (RecordingMark('made up'),),
        (15.0, 35.0))


def noise_of(robot):
    """Return the RMS (n,) [Nm] of one row's torque noise."""
    return 4e-3 * robot.limits.torque


class Hidden:
    """What a hidden effect may use of one run: EffectInput x, its times and the torque so far."""

    def __init__(self, robot, x, motion, torque):
        self.robot, self.x, self.motion, self.torque = robot, x, motion, torque
        self.noise = noise_of(robot)


@lru_cache(None)
def clean_runs(seconds, names=None, celsius=(15.0, 35.0)):
    """Return (EffectInput, Motion, torque without noise (N, n)) of each run."""
    model = declared_model(names=names)
    robot, rng, runs = model.robot, np.random.default_rng(11), []
    for k in range(RUNS):
        motion = waves(robot, rng, seconds, celsius[k % 2])
        distance = presliding_distances(robot.n, effect_uses(robot))
        x, _ = motion_input(robot, motion, distance)
        full = ColumnLayout(robot.n, effect_uses(robot))
        torque = torque_columns(robot, full, x) @ true_parameters(robot, effect_uses(robot))
        runs.append((x, motion, torque))
    return runs


def recorded(*hidden, seconds=SECONDS, seed=5, names=None, celsius=(15.0, 35.0)):
    """Return the Evidence of RUNS runs of the arm with hidden effects: functions of Hidden."""
    robot, rng = declared_model(names=names).robot, np.random.default_rng(seed)
    found = []
    for k, (x, motion, torque) in enumerate(clean_runs(seconds, names, celsius)):
        noise = rng.normal(size=torque.shape) * noise_of(robot)
        more = sum((effect(Hidden(robot, x, motion, torque)) for effect in hidden),
                   np.zeros_like(torque))
        found.append(Evidence(f'run {k}', motion, torque + more + noise))
    return found


def diagnosed(*hidden, model=None, **keywords):
    """Return (Diagnosis, better model) of an arm with hidden effects; the last run is to test."""
    evidence = recorded(*hidden, **keywords)
    return diagnose(model or declared_model(), evidence[:-1], evidence[-1:])


def told(diagnosis):
    """Return the confirmed findings as a mapping of name to joints."""
    return {f.name: f.joints for f in diagnosis.findings if f.verdict == CONFIRMED}


def on(joint, times, function):
    """Return an effect of one joint with an RMS of so many times the noise: function(Hidden)."""
    robot = declared_model().robot
    whole = np.concatenate([function(Hidden(robot, *run))[:, joint]
                            for run in clean_runs(SECONDS)])
    size = times * noise_of(robot)[joint] / np.sqrt(np.mean(whole ** 2))

    def effect(run):
        out = np.zeros_like(run.torque)
        out[:, joint] = size * function(run)[:, joint]
        return out
    return effect


def ripple(run):
    """A ripple slow enough to pass the motion filter as it is."""
    return np.sin(23.4 * run.x.q + 0.5)


def cable(run):
    return np.exp(0.9 * run.x.q) - 1.0


def viscous(run):
    return run.x.v


def late(run):
    """Effort of one sample ago, on all joints."""
    return np.concatenate([run.torque[:1], run.torque[:-1]]) - run.torque


def a_little_late(run):
    """Effort of 9 ms ago, on all joints."""
    time = run.motion.stamp
    return np.stack([np.interp(time - 0.009, time, torque) for torque in run.torque.T],
                    axis=1) - run.torque


def misread(run):
    """Effort 2 % too large, on all joints."""
    return 0.02 * run.torque


def play(run):
    """Every gear with a gap of 4 mrad."""
    gear = np.array([run.robot.rigid_torque(*row) for row in zip(run.x.q, run.x.v, run.x.a)])
    return play_columns(run.robot, run.x.q, gear, run.motion.dt)(
        np.arange(4), np.full(4, 0.004), np.full(4, 0.012), np.ones(4), np.full(4, 0.009))


def leaning(run, x=0.02, y=-0.03):
    """Gravity turned by small angles [rad] about x and y, exactly."""
    tilted = four_axes(gravity=(turned(x, y) @ [0.0, 0.0, -9.81]).tolist())
    zero = np.zeros(4)
    return np.array([tilted.rigid_torque(q, zero, zero) - run.robot.rigid_torque(q, zero, zero)
                     for q in run.x.q])


def turned(x, y):
    """Return the rotation by a small vector (x, y, 0) [rad]."""
    k = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
    angle = np.hypot(x, y)
    return np.eye(3) + np.sin(angle) / angle * k + (1.0 - np.cos(angle)) / angle ** 2 * k @ k


def resonance(run):
    """Friction with a narrow peak in speed: no effect of the vocabulary."""
    return np.sign(run.x.v) * np.exp(-((np.abs(run.x.v) - 0.45) / 0.05) ** 2)


def warming(run):
    return np.sign(run.x.v) * run.x.warmth


def stretched(run):
    """A rotor heavier than declared."""
    return run.x.a


def turned_late(run):
    """Friction that turns over a long way, and then is at its level."""
    way = np.full(run.robot.n, 0.02), np.full(run.robot.n, 2.0)
    return presliding_path(run.motion.q, run.motion.v, run.motion.dt, *way)[0] - run.x.z


def peak(run):
    """A Stribeck peak as the motion filter shows it."""
    return run.x.shown(np.arange(run.robot.n), 2e-3, np.inf, 0.1)


def thinning(run):
    """A power-law fluid: friction with the square root of speed."""
    return np.sign(run.x.v) * np.sqrt(np.abs(run.x.v))


def constant_friction(run):
    return np.sign(run.x.v)


def assert_only(diagnosis, name, joints, alternatives=()):
    """Hold that one effect was found, and what it was not told apart from."""
    assert [f.name for f in diagnosis.findings] == [name]
    found = diagnosis.findings[0]
    robot = declared_model().robot
    assert found.joints == tuple(robot.joints[j] for j in joints)
    assert found.verdict == CONFIRMED
    assert set(alternatives) <= {other.name for other in found.alternatives}
    assert found.evidence.gain > found.evidence.needed > 8.0
    return found


def assert_repaired(diagnosis, joint):
    """Hold that a joint's error goes back to its noise and no other joint's grows."""
    noise = noise_of(declared_model().robot)
    assert diagnosis.before[joint] > 1.3 * noise[joint]
    assert (diagnosis.after < 1.12 * noise).all()
    assert (diagnosis.after <= diagnosis.before * 1.005).all()


# Nothing, and one.

@pytest.mark.parametrize('seed', [5, 6])
def test_nothing_is_found_where_nothing_is(seed):
    diagnosis, better = diagnosed(seed=seed)
    assert diagnosis.findings == () and better is declared_model()
    np.testing.assert_array_equal(diagnosis.before, diagnosis.after)
    np.testing.assert_allclose(diagnosis.noise_floor, noise_of(better.robot), rtol=0.15)
    assert diagnosis.cannot_tell == () and (diagnosis.unexplained < 0.2).all()


@pytest.mark.parametrize('joint, effect, name, change', [
    (2, viscous, 'viscous_friction', 'change_of_coefficient'),
    (0, constant_friction, 'coulomb_friction', 'change_of_level'),
    (3, stretched, 'rotor_inertia', 'change_of_inertia')])
def test_a_changed_effect_is_found_on_its_joint_with_its_change(joint, effect, name, change):
    hidden = on(joint, 2.0, effect)
    diagnosis, _ = diagnosed(hidden)
    found = assert_only(diagnosis, name, [joint])
    assert found.changed
    assert_repaired(diagnosis, joint)
    run = Hidden(declared_model().robot, *clean_runs(SECONDS)[0])
    values = effect(run)[:, joint]
    size = (hidden(run)[:, joint] @ values) / (values @ values)
    mean, std, _ = found.parameters[change]
    assert abs(mean - size) < 4.0 * std + 0.02 * size and std < 0.1 * size


def test_a_ripple_is_found_with_its_period():
    diagnosis, _ = diagnosed(on(2, 2.0, ripple))
    found = assert_only(diagnosis, 'torque_ripple', [2])
    periods, std, _ = found.parameters['periods']
    assert abs(periods - 23.4) < 3.0 * std and 0.005 < std < 0.1
    size = 2.0 * np.sqrt(2.0) * noise_of(declared_model().robot)[2]
    assert found.parameters['amplitude'][0] == pytest.approx(size, rel=0.1)
    assert found.explained[2] > 0.7 and (np.delete(found.explained, 2) == 0.0).all()
    assert_repaired(diagnosis, 2)


def test_a_cable_is_found():
    diagnosis, _ = diagnosed(on(1, 2.0, cable))
    found = assert_only(diagnosis, 'cable_drag', [1])
    # A spring is not excluded by a motion over less than a turn: the motion that would is told.
    if 'gravity_spring' in [other.name for other in found.alternatives]:
        assert 'whole turn' in found.advice
    assert_repaired(diagnosis, 1)


def test_friction_that_changes_with_temperature_is_found():
    diagnosis, _ = diagnosed(on(1, 2.0, warming))
    assert_only(diagnosis, 'temperature_dependent_coulomb_friction', [1])
    assert_repaired(diagnosis, 1)


def test_friction_that_grows_less_than_speed_is_found_as_such():
    diagnosis, _ = diagnosed(on(1, 4.0, thinning))
    found = assert_only(diagnosis, 'shear_thinning_friction', [1])
    assert found.parameters['level'][0] > 0.0 and found.parameters['thinning_velocity'][0] > 0.0
    assert_repaired(diagnosis, 1)


@pytest.mark.parametrize('effect, name, shape', [
    (turned_late, 'presliding_hysteresis', {'presliding_distance': 0.02, 'power': 2.0}),
    (peak, 'stribeck_friction', {'travel': 2e-3, 'stribeck_velocity': 0.1})])
def test_the_way_in_which_friction_turns_is_found(effect, name, shape):
    diagnosis, better = diagnosed(on(1, 8.0, effect))
    assert told(diagnosis) == {name: (declared_model().robot.joints[1],)}
    (use,) = [use for use in better.uses if (use.name, use.joint) == (name, 1)]
    for figure, true in shape.items():
        assert use.shape[figure] == pytest.approx(true, rel=0.4)


def test_effort_that_comes_late_is_one_finding():
    """All joints are late by one sample: one cause, with the same delay on each."""
    diagnosis, _ = diagnosed(late)
    found = assert_only(diagnosis, 'time_delay', range(4))
    delays = [found.parameters[f'delay ({joint})'][:2] for joint in found.joints]
    for mean, std in delays:
        assert abs(mean - DT) < 4.0 * std and std < 0.5 * DT
    assert (diagnosis.after < diagnosis.before).all()


def alone(effect, joint):
    """Return an effect (function of Hidden) on one joint only."""
    return lambda run: effect(run) * (np.arange(run.robot.n) == joint)


@pytest.mark.parametrize('effect, name, parameter, truth', [
    (a_little_late, 'time_delay', 'delay', 0.009), (misread, 'torque_scale', 'gain', 0.02)])
def test_joints_show_together_what_none_shows_alone(effect, name, parameter, truth):
    """One parameter for all of them: no joint is told by itself, and none has to be."""
    diagnosis, better = diagnosed(effect)
    found = assert_only(diagnosis, name, range(4))
    for joint in found.joints:
        mean, std, _ = found.parameters[f'{parameter} ({joint})']
        assert abs(mean - truth) < 4.0 * std + 0.1 * truth
    assert diagnosis.after.sum() < diagnosis.before.sum()
    for joint in range(4):
        residual = find_residual(declared_model(), recorded(alone(effect, joint))[:-1])
        assert Trace(declared_model(), residual, range(4)).run() == []


def test_what_joints_have_in_common_is_one_parameter():
    """Its parts are the joints', its evidence, on whatever blocks, that of all together."""
    residual = find_residual(declared_model(), recorded(misread)[:-1])
    trace = Trace(declared_model(), residual, range(4))
    trace.run()
    chosen = trace.steps[0].chosen
    assert chosen.common and chosen.size == 1 and chosen.joints == chosen.touched == [0, 1, 2, 3]
    sizes = {float(score.theta[0] * h.scale[0]) for h, score in chosen.parts}
    assert len(sizes) == 1 and sizes.pop() == pytest.approx(0.02, abs=0.003)
    again = trace.still_gains(trace.steps[0])
    assert again.gain == pytest.approx(chosen.gain) and again.common


@pytest.mark.parametrize('hidden, more', [((), False), ((late,), True)])
def test_every_shape_that_is_tried_counts_as_a_trial(hidden, more):
    """Those of the search between the grid's values too, where there is something to search."""
    model = declared_model()
    residual = find_residual(model, recorded(*hidden)[:-1])
    trace = Trace(model, residual, range(4))
    trace.run()
    grid = sum(h.trials for h in hypotheses(model, residual, residual.blocks(), range(4)))
    assert (trace.trials > grid) == more and trace.trials >= grid


def test_play_is_found_with_its_gap():
    diagnosis, _ = diagnosed(on(1, 2.0, play))
    found = assert_only(diagnosis, 'backlash', [1])
    assert found.parameters['travel'][0] == pytest.approx(0.004, rel=0.15)
    assert found.parameters['impact'][0] == pytest.approx(0.009, rel=0.3)
    assert_repaired(diagnosis, 1)


@pytest.mark.parametrize('gains, sure', [
    ([50.0] * 4, True), ([50.0] * 3, False), ([20.0] * 4, False),
    ([200.0] * 6 + [-20.0] * 3, False), ([20.0, 200.0] * 4 + [-5.0], True),
    ([400.0] * 3 + [-2.0], True), ([400.0] * 2, False), ([4000.0, 30.0, 30.0], False)])
def test_what_gains_wherever_it_acts_is_sure(gains, sure):
    """Rare but steady: crossings of a gap in a few of 60 blocks; chance loses as often."""
    by_block = np.zeros(60)
    by_block[:len(gains)] = gains
    std = float(np.sqrt(60) * by_block.std())
    assert significant(Candidate('backlash', (), float(by_block.sum()), 10.0 * std,
                                 by_block)) is sure


def test_a_leaning_base_is_one_finding():
    diagnosis, _ = diagnosed(leaning)
    found = assert_only(diagnosis, 'base_tilt', range(4))
    for (name, _), truth in zip(EFFECTS['base_tilt'].parameters, (0.02, -0.03)):
        mean, std, unit = found.parameters[name]
        assert abs(mean - truth) < 4.0 * std + 5e-4 and std < 5e-3 and unit == 'rad'
    assert_repaired(diagnosis, 1)


def test_a_base_that_leans_far_is_taken_exactly():
    """To first order only, what is left of such a turn looks like a heavier link."""
    def far(run):
        return leaning(run, 0.12, -0.1)
    model, evidence = declared_model(), recorded(far)
    residual = find_residual(model, evidence)
    blocks = residual.blocks()
    first = next(h for h in hypotheses(model, residual, blocks, ()) if h.name == 'base_tilt')
    score = blocks.evaluate(first.columns)
    exact = turned_exactly(first, score, model, residual)
    better = blocks.evaluate(exact.columns)
    truth = np.concatenate([far(Hidden(model.robot, x, motion, torque))
                            for x, motion, torque in clean_runs(SECONDS)])
    left = [np.linalg.norm(truth[:, 1] - h.columns[1] @ s.theta)
            for h, s in ((first, score), (exact, better))]
    assert left[1] < 0.3 * left[0] and better.gain > score.gain
    assert better.theta * exact.scale == pytest.approx([0.12, -0.1], abs=2e-3)


# Two, and none of the known.

def test_effects_on_two_joints_are_both_found():
    diagnosis, _ = diagnosed(on(2, 2.0, ripple), on(0, 2.0, viscous))
    robot = declared_model().robot
    assert told(diagnosis) == {'torque_ripple': (robot.joints[2],),
                               'viscous_friction': (robot.joints[0],)}
    assert len(diagnosis.findings) == 2
    assert_repaired(diagnosis, 0)


def test_two_effects_of_one_joint_are_both_found():
    diagnosis, _ = diagnosed(on(1, 2.0, ripple), on(1, 2.0, viscous))
    joint = (declared_model().robot.joints[1],)
    assert told(diagnosis) == {'torque_ripple': joint, 'viscous_friction': joint}
    assert_repaired(diagnosis, 1)


def test_what_has_no_name_is_unknown_with_its_variable():
    """Friction with a narrow peak in speed must not become Stribeck, ripple or a contact."""
    diagnosis, better = diagnosed(on(2, 4.0, resonance))
    assert [(f.name, f.joints, f.variables) for f in diagnosis.findings] == [
        (UNKNOWN, (better.robot.joints[2],), ('velocity',))]
    assert diagnosis.unexplained_most[2] > 0.3
    assert {(u.name, u.joint) for u in better.uses} \
        == {(u.name, u.joint) for u in declared_model().uses}


@pytest.mark.parametrize('named, nameless, verdicts', [
    (12.0, 2.5, {'viscous_friction': CONFIRMED, UNKNOWN: SUSPECTED}),
    (3.0, 4.0, {'viscous_friction': SUSPECTED, UNKNOWN: SUSPECTED})])
def test_a_small_rest_without_a_name_does_not_speak_against_a_large_effect(named, nameless,
                                                                           verdicts):
    diagnosis, _ = diagnosed(on(2, named, viscous), on(2, nameless, resonance))
    assert {f.name: f.verdict for f in diagnosis.findings} == verdicts


@pytest.mark.parametrize('doubt, expected', [(0.2, []), (1e-3, ['viscous_friction'])])
def test_a_change_that_the_model_expects_is_no_finding(doubt, expected):
    """The same change: news to a model that is sure, none to one that says it may be off."""
    diagnosis, _ = diagnosed(on(2, 0.8, viscous), model=declared_model(doubt))
    assert [f.name for f in diagnosis.findings] == expected


def candidate(name, gain, spread=0.0):
    """Return a Candidate of joint 0: nats of gain in ten blocks, by turns so much more or less."""
    hypothesis = Hypothesis(name, 0, {0: np.ones((4, 1))}, np.ones(1))
    by_block = gain / 10.0 + spread * np.array([1.0, -1.0] * 5)
    return Candidate(name, ((hypothesis, None),), gain, standard_error(by_block), by_block)


@pytest.mark.parametrize('gain, rival', [(5.0, 'viscous_friction'), (-5.0, None)])
def test_what_gains_nothing_is_no_rival(gain, rival):
    best, other = candidate('rotor_inertia', 900.0), candidate('viscous_friction', gain)
    step = Trace._step(None, best, [best, other], 30.0)
    assert step.chosen is best and step.alternatives == ()
    assert (step.next_best and step.next_best.name) == rival


@pytest.mark.parametrize('other', ['cable_drag', 'rotor_inertia'])
@pytest.mark.parametrize('gain, spread, told', [
    (1900.0, 5.0, True), (1900.0, 20.0, False), (840.0, 20.0, True), (1990.0, 0.0, True)])
def test_an_alternative_is_what_blocks_cannot_tell(other, gain, spread, told):
    """What falls behind in every block is told, however little; not of a pair of the design."""
    best = candidate('gravity_spring', 2000.0)
    rival = candidate(other, gain, spread)
    step = Trace._step(None, best, [best, rival], 30.0)
    told = told and not (other == 'cable_drag' and gain == 1990.0)
    assert step.chosen is best and step.alternatives == (() if told else (rival,))


def test_of_pairs_of_the_design_only_those_of_one_joint_are_named_together():
    best, rival = candidate('gravity_spring', 2000.0), candidate('link_inertia', 1990.0)
    elsewhere = Candidate(rival.name, tuple((replace(h, joint=1), s) for h, s in rival.parts),
                          rival.gain, rival.std, rival.by_block)
    step = Trace._step(None, best, [best, rival, elsewhere], 30.0)
    assert step.alternatives == (rival,)


def test_what_gains_no_more_than_chance_is_no_alternative():
    best, rival = candidate('gravity_spring', 200.0, -12.0), candidate('cable_drag', 130.0, 12.0)
    weak = candidate('torque_offset', 60.0, 40.0)
    step = Trace._step(None, best, [best, rival, weak], 30.0)
    assert step.alternatives == (rival,)


# What the result promises.

def test_the_better_model_holds_what_the_report_says():
    """Every effect the old model did not have is a finding, and the reverse."""
    model = declared_model()
    for hidden in ((on(1, 2.0, ripple), on(1, 2.0, cable)), (on(1, 3.0, cable), late)):
        diagnosis, better = diagnosed(*hidden)
        old = {(u.name, u.joint) for u in model.uses}
        new = {(u.name, better.robot.joints[u.joint]) for u in better.uses
               if (u.name, u.joint) not in old}
        reported = {(f.name, joint) for f in diagnosis.findings for joint in f.joints
                    if not f.changed}
        assert new == reported


def test_tests_are_used_for_nothing_but_errors():
    """A test recording of another arm changes no finding and no parameter."""
    evidence = recorded(on(2, 2.0, ripple))
    other = recorded(on(2, 2.0, ripple), on(1, 5.0, viscous))[-1:]
    (one, first), (two, second) = (diagnose(declared_model(), evidence[:-1], test)
                                   for test in (evidence[-1:], other))
    assert [f.name for f in one.findings] == [f.name for f in two.findings] == ['torque_ripple']
    np.testing.assert_array_equal(first.mean, second.mean)
    assert two.before[1] > 2.0 * one.before[1] and two.after[1] > 2.0 * one.after[1]
    assert (one.tested_on, two.tested_on) == ('run 3', 'run 3')
    assert one.recordings == ('run 0', 'run 1', 'run 2')


def test_without_tests_the_last_quarter_is_kept():
    evidence = recorded(on(2, 2.0, ripple))
    diagnosis, _ = diagnose(declared_model(), evidence)
    assert told(diagnosis) == {'torque_ripple': (declared_model().robot.joints[2],)}
    assert 'quarter' in diagnosis.tested_on
    assert_repaired(diagnosis, 2)
    # The same, with what happens in the last quarter only: nothing is found, all of it is error.
    late_part = [Evidence(e.name, e.motion, np.where(
        (np.arange(len(e.torque)) >= 0.75 * len(e.torque))[:, None],
        bad.torque, e.torque)) for e, bad in zip(recorded(), evidence)]
    diagnosis, _ = diagnose(declared_model(), late_part)
    assert diagnosis.findings == ()
    assert diagnosis.after[2] == diagnosis.before[2] > 1.5 * noise_of(four_axes())[2]


def test_the_residual_is_measured_less_modelled():
    """One row of the residual against the model's own torque, without any detour."""
    model, evidence = declared_model(), recorded()
    residual = find_residual(model, evidence)
    np.testing.assert_allclose(
        residual.residual, np.concatenate([e.torque - clean for e, (_, _, clean) in zip(
            evidence, clean_runs(SECONDS))]), atol=1e-9)
    assert list(np.unique(residual.owner)) == [0, 1, 2, 3]
    assert len(np.unique(residual.folds)) == RUNS
    # No block belongs to two recordings.
    owners = residual.owner[residual.starts]
    np.testing.assert_array_equal(owners, residual.folds)
    assert residual.moving.mean() > 0.5
