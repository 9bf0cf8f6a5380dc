"""The trace: one hidden effect comes out as itself on its joint, two as two, none as none."""

from functools import lru_cache

from effect_helpers import DT
import numpy as np
import pytest
from residual_helpers import (a_little_late, alone, assert_only, assert_repaired, cable,
                              clean_runs, constant_friction, declared_model, diagnosed,
                              heavier_links, Hidden, late, leaning, levelling, misread,
                              narrow_peak, noise_of, on, peak, play, recorded, resonance,
                              ripple, SECONDS, stretched, thinning, told, turned_late, viscous,
                              warming)

from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.residual.diagnosis import CONFIRMED, SUSPECTED, UNKNOWN
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.candidate import single
from hand_load_estimator.residual.tracing.hypotheses import hypotheses
from hand_load_estimator.residual.tracing.leaning_base import turned as turned_exactly
from hand_load_estimator.residual.tracing.trace import Trace


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


@pytest.mark.parametrize('effect, exponent', [(thinning, 0.7), (levelling, None)])
@pytest.mark.parametrize('times', [4.0, 12.0])
def test_friction_that_grows_less_than_speed_is_found_as_such(effect, exponent, times):
    diagnosis, _ = diagnosed(on(1, times, effect))
    found = assert_only(diagnosis, 'shear_thinning_friction', [1])
    assert found.parameters['level'][0] > 0.0 and found.parameters['thinning_velocity'][0] > 0.0
    # A small effect does not tell its form.
    assert ('exponent' in found.parameters) == bool(exponent and times > 4.0)
    if 'exponent' in found.parameters:
        # Truly 0.5: beside free viscous friction much thins fast what these speeds show.
        assert found.parameters['exponent'][0] == pytest.approx(exponent, abs=0.15)
    assert_repaired(diagnosis, 1)


@lru_cache
def turning(effect):
    """Return (Diagnosis, better model) of friction that turns in a way of its own on joint 1."""
    return diagnosed(on(1, 8.0, effect))


@pytest.mark.parametrize('effect, name, shape', [
    (turned_late, 'presliding_hysteresis', {'presliding_distance': 0.02, 'plastic': 0.8}),
    (peak, 'stribeck_friction', {'travel': 2e-3, 'stribeck_velocity': 0.1, 'exponent': 1.0,
                                 'velocity_range': np.inf, 'plastic': 2.0}),
    # Of contacts of its own hardly told from the joint's, bent further.
    (narrow_peak, 'stribeck_friction', {'stribeck_velocity': 0.1, 'exponent': 1.8,
                                        'velocity_range': 30.0})])
def test_the_way_in_which_friction_turns_is_found(effect, name, shape):
    diagnosis, better = turning(effect)
    assert told(diagnosis) == {name: (declared_model().robot.joints[1],)}
    (use,) = [use for use in better.uses if (use.name, use.joint) == (name, 1)]
    for figure, true in shape.items():
        assert use.shape[figure] == pytest.approx(true, rel=0.4)


def test_what_temperature_does_to_a_peak_is_not_told_where_none_changed():
    """At one temperature any range goes with some velocity."""
    _, better = diagnosed(on(1, 8.0, peak), celsius=(15.0, 15.0))
    (use,) = [u for u in better.uses if (u.name, u.joint) == ('stribeck_friction', 1)]
    assert use.shape['velocity_range'] == np.inf
    assert use.shape['travel'] < 1e-2


def test_effort_that_comes_late_is_one_finding():
    """All joints are late by one sample: one cause, with the same delay on each."""
    diagnosis, _ = diagnosed(late)
    found = assert_only(diagnosis, 'time_delay', range(4))
    delays = [found.parameters[f'delay ({joint})'][:2] for joint in found.joints]
    for mean, std in delays:
        assert abs(mean - DT) < 4.0 * std and std < 0.5 * DT
    # Joints that agree have one shift, and of a short one only its product with the share shows.
    (shift,) = {found.parameters[f'shift ({joint})'][0] for joint in found.joints}
    assert shift == pytest.approx(DT, rel=0.1)
    assert (diagnosis.after < diagnosis.before).all()


@pytest.mark.parametrize('effect, name, parameter, truth', [
    (a_little_late, 'time_delay', 'delay', 0.009), (misread, 'torque_scale', 'gain', 0.02)])
def test_joints_show_together_what_none_shows_alone(effect, name, parameter, truth):
    """One parameter for all of them: no joint is told by itself, and none has to be."""
    diagnosis, better = diagnosed(effect)
    found = assert_only(diagnosis, name, range(4))
    for joint in found.joints:
        mean, std, _ = found.parameters[f'{parameter} ({joint})']
        assert abs(mean - truth) < 4.0 * std + 0.1 * truth
    # What all of them gain is ahead of the next best, which is of another cause.
    assert found.evidence.next_best not in (None, name)
    assert 0.0 < found.evidence.margin < found.evidence.gain
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


def test_a_leaning_base_is_one_finding():
    diagnosis, _ = diagnosed(leaning)
    found = assert_only(diagnosis, 'base_tilt', range(4))
    for (name, _), truth in zip(EFFECTS['base_tilt'].parameters, (0.02, -0.03)):
        mean, std, unit = found.parameters[name]
        assert abs(mean - truth) < 4.0 * std + 5e-4 and std < 5e-3 and unit == 'rad'
    angle, std, unit = found.parameters['angle']
    assert abs(angle - np.hypot(0.02, 0.03)) < 4.0 * std + 5e-4 and unit == 'rad'
    assert std <= max(found.parameters[name][1] for name, _ in EFFECTS['base_tilt'].parameters)
    assert_repaired(diagnosis, 1)


@pytest.mark.parametrize('hidden, better', [(leaning, False), (heavier_links, True)])
def test_a_leaning_base_is_weighed_against_all_links_at_once(hidden, better):
    """No single link moves all joints as a base does; several do, where no axis is upright."""
    model = declared_model()
    trace = Trace(model, find_residual(model, recorded(hidden)), ())
    trace._evaluate()
    tilt = single(*next(pair for key, pair in trace._scores.items() if key[0] == 'base_tilt'))
    step = trace._step(tilt, [tilt], 30.0)
    (links,) = step.alternatives
    assert step.chosen is tilt and (links.name, links.joints) == ('link_inertia', [0, 1, 2, 3])
    assert (links.gain > tilt.gain) == better and links.gain > 0.95 * tilt.gain


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


def test_shapes_settle_beside_what_is_found_later():
    """The first of two friction effects on a joint takes some of the other until that is known."""
    alone, _ = turning(narrow_peak)
    both, _ = diagnosed(on(1, 8.0, narrow_peak), on(1, 4.0, stretched), on(1, 4.0, cable))
    velocity, beside = (next(f for f in d.findings if f.name == 'stribeck_friction')
                        .parameters['stribeck_velocity'][0] for d in (alone, both))
    assert beside == pytest.approx(velocity, rel=0.05)


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


FRICTION = {'viscous_friction': viscous, 'coulomb_friction': constant_friction}


@pytest.mark.parametrize('joint, times, effects', [
    (1, 6.0, FRICTION),
    (1, 6.0, {'stribeck_friction': peak, 'temperature_dependent_coulomb_friction': warming})])
def test_two_effects_that_look_like_a_third_together_are_both_found(joint, times, effects):
    """A lubricant that thins or cools explains more than either of the two alone."""
    diagnosis, _ = diagnosed(*(on(joint, times, effect) for effect in effects.values()))
    assert told(diagnosis) == dict.fromkeys(effects, (declared_model().robot.joints[joint],))
    assert len(diagnosis.findings) == 2
    assert_repaired(diagnosis, joint)
    # Each is told from its rivals beside the other, in the same blocks.
    assert all(f.evidence.margin is None or f.evidence.margin > -2.0 for f in diagnosis.findings)


def test_two_with_names_are_told_where_one_without_leaves_nothing():
    """Unequal friction levels beside more of both are one function of velocity with two names."""
    def unequal(run):
        return np.abs(np.sign(run.x.v))
    diagnosis, _ = diagnosed(on(1, 3.0, unequal), on(1, 3.0, constant_friction))
    joint = (declared_model().robot.joints[1],)
    found = told(diagnosis)
    assert set(found) in ({'coulomb_friction', 'friction_asymmetry'},
                          {'coulomb_friction', 'torque_offset'})
    assert set(found.values()) == {joint}
    one = next(f for f in diagnosis.findings if f.name != 'coulomb_friction')
    # Both are constant while the joint slides one way: neither is told without the other.
    assert {one.name, *(other.name for other in one.alternatives)} \
        >= {'friction_asymmetry', 'torque_offset'}
    assert_repaired(diagnosis, 1)


def test_what_has_no_name_is_unknown_with_its_variable():
    """Friction with a narrow peak in speed must not become Stribeck, ripple or a contact."""
    diagnosis, better = diagnosed(on(2, 4.0, resonance))
    assert [(f.name, f.joints, f.variables) for f in diagnosis.findings] == [
        (UNKNOWN, (better.robot.joints[2],), ('velocity',))]
    assert diagnosis.unexplained_most[2] > 0.3
    declared = {(u.name, u.joint) for u in declared_model().uses}
    assert {(u.name, u.joint) for u in better.uses} == declared
    # A learned function is offered beside, marked as none of physics, with what it is worth.
    offered = diagnosis.correction
    assert {(u.name, u.joint) for u in offered.model.uses} - declared \
        == {('learned_velocity_correction', 2)}
    assert offered.after[2] < 1.3 * noise_of(better.robot)[2] < 0.3 * diagnosis.after[2]
    assert any('it is no explanation' in text and better.robot.joints[2] in text
               for text in diagnosis.remains)


def test_no_two_impossible_effects_stand_in_for_what_has_no_name():
    """Coulomb below zero beside a Stribeck peak, or a lubricant of negative friction, would."""
    diagnosis, _ = diagnosed(on(1, 12.0, lambda run: run.x.v * np.abs(run.x.v)))
    assert [f.name for f in diagnosis.findings if f.verdict == CONFIRMED] == [UNKNOWN]
    assert not any('impossible' in text for text in diagnosis.remains)


@pytest.mark.parametrize('named, nameless, verdicts', [
    (12.0, 2.5, {'viscous_friction': CONFIRMED, UNKNOWN: SUSPECTED}),
    (3.0, 4.0, {'viscous_friction': SUSPECTED, UNKNOWN: CONFIRMED})])
def test_a_small_rest_without_a_name_does_not_speak_against_a_large_effect(named, nameless,
                                                                           verdicts):
    diagnosis, _ = diagnosed(on(2, named, viscous), on(2, nameless, resonance))
    assert {f.name: f.verdict for f in diagnosis.findings} == verdicts


@pytest.mark.parametrize('doubt, expected', [(0.2, []), (1e-3, ['viscous_friction'])])
def test_a_change_that_the_model_expects_is_no_finding(doubt, expected):
    """The same change: news to a model that is sure, none to one that says it may be off."""
    diagnosis, _ = diagnosed(on(2, 0.8, viscous), model=declared_model(doubt))
    assert [f.name for f in diagnosis.findings] == expected


def test_what_the_model_expects_is_in_the_model_written_all_the_same():
    """Two recordings say to expect much; a large change is told, with no cause."""
    diagnosis, better = diagnosed(on(2, 8.0, viscous), model=declared_model(2.0))
    assert not diagnosis.findings
    assert_repaired(diagnosis, 2)
    joint = better.robot.joints[2]
    told = [s for s in diagnosis.cannot_tell if f'viscous_friction of {joint}' in s]
    assert len(told) == 1 and 'model.yaml has the change' in told[0]
