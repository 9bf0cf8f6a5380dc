"""The effects suite: cases as stated, and their figures against the plant's own."""

from collections import Counter
from dataclasses import replace

from core_helpers import effect_uses, exact_model, messages, recording_of
import numpy as np
from plant_helpers import ur10e
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark.effect_cases import (EffectCase, Hidden, load_seeds,
                                                        NOT_IN_VOCABULARY, place, suite_cases)
from hand_load_estimator.benchmark.effect_errors import torque_rmse
from hand_load_estimator.benchmark.effect_truth import (COMPARABLE, IN_REPORT_ONLY, model_change,
                                                        stated, true_change)
from hand_load_estimator.benchmark.suites import cases_of, SUITES
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.plant.hidden import EFFECTS
from hand_load_estimator.stream.joint_stream import motion_of
from hand_load_estimator.torque.presliding import Turning

PLANT = seeds.DEVELOPMENT_PLANTS[95]
JOINT = 'elbow_joint'


def test_the_suite_holds_what_the_issue_asks_for():
    suite = suite_cases(ur10e())
    assert Counter(c.kind for c in suite) == {
        'single': 132, 'pair': 12, 'same_joint': 8, 'common': 6, 'clean': 20, 'blind': 20,
        'alone': 20, 'outside': 18}
    assert len({c.label for c in suite}) == len(suite)
    singles = Counter((h.name, h.strength) for c in suite if c.kind == 'single' for h in c.hidden)
    names = set(EFFECTS) - set(NOT_IN_VOCABULARY)
    assert singles == {(name, s): 2 for name in names for s in (0.5, 2.0, 5.0)}
    assert {h.name for c in suite if c.kind == 'outside' for h in c.hidden} \
        == {'speed_resonance_friction', 'swinging_load', 'saturating_drive'}
    assert len({c.plant for c in suite if c.kind == 'clean'}) == 20
    assert [c.plant for c in suite] == sorted(c.plant for c in suite)
    for case in suite:
        assert len({h.name for h in case.hidden}) == len(case.hidden)


def test_the_same_seeds_give_the_same_cases_and_development_others():
    robot = ur10e()
    assert suite_cases(robot) == suite_cases(robot)
    plants = {c.plant for c in suite_cases(robot)}
    looked_at = {c.plant for c in suite_cases(robot, development=True)}
    accuracy = {plant for plant, _ in cases_of(SUITES['base'], 2000)}
    assert plants == set(seeds.FINAL_EFFECT_PLANTS) and not plants & accuracy
    assert looked_at <= set(range(540, 600))


def test_loads_are_of_no_other_plant_or_suite():
    plants = sorted({c.plant for c in suite_cases(ur10e())})
    drawn = [seed for plant in plants for seed in load_seeds(plant, 6)]
    assert len(set(drawn)) == 6 * len(plants) and set(drawn) <= set(seeds.FINAL_EFFECT_CASES)
    accuracy = {seed for _, part in cases_of(SUITES['base'], 2000) for seed in part}
    assert not set(drawn) & accuracy
    assert set(load_seeds(545, 6)) <= set(seeds.DEVELOPMENT_CASES)


def test_an_effect_goes_where_it_can_be_so_strong():
    """Gravity never lets go of the shoulder's teeth: backlash takes the next joint."""
    robot = ur10e()
    lift, elbow = (robot.joints.index(name) for name in ('shoulder_lift_joint', JOINT))
    case = EffectCase('single', PLANT, (Hidden('backlash', 2.0, (lift, elbow)),))
    assert place(robot, case) == [{'name': 'backlash', 'strength': 2.0, 'joints': [JOINT]}]
    impossible = Hidden('temperature_dependent_viscous_friction', 500.0, (0, 1))
    with pytest.raises(ConfigurationError, match='viscous.*so strong on any joint'):
        place(robot, EffectCase('single', PLANT, (impossible,)))


def test_effects_of_a_pair_take_different_joints():
    pair = (Hidden('torque_offset', 3.0, (2, 1)), Hidden('torque_scale', 3.0, (2, 4)))
    first, second = place(ur10e(), EffectCase('pair', PLANT, pair))
    assert (first['joints'], second['joints']) == ([JOINT], ['wrist_2_joint'])


def test_effects_of_the_whole_arm_name_no_joint():
    case = EffectCase('single', PLANT, (Hidden('base_tilt', 2.0),))
    assert place(ur10e(), case) == [{'name': 'base_tilt', 'strength': 2.0}]


# Figures against the plant's.

@pytest.mark.parametrize('name, parameters, expected', [
    ('torque_ripple', {'torque': 3.0, 'periods': 71.0}, {'amplitude': 3.0, 'periods': 71.0}),
    ('gravity_spring', {'stiffness': 30.0, 'angle': 0.5}, {'stiffness': 30.0}),
    ('backlash', {'gap': 0.004, 'inertia': 0.5}, {'travel': 0.004}),
    ('base_tilt', {'angle': 0.05}, {'angle': 0.05}),
    ('viscous_friction', {'coefficient': 4.0}, {'coefficient': 4.0}),
    ('temperature_dependent_coulomb_friction', {'fall': 0.02}, {'slope': -0.02}),
    ('torque_scale', {'gain': 0.25}, {'gain': 0.25}),
    ('time_delay', {'delay': 0.02}, {'delay': 0.02}),
    ('load_change', {'mass': 1.2}, {'mass': 1.2}),
    ('external_contact', {'force': 10.0, 'direction': [0.6, 0.0, -0.8], 'start': 4.0,
                          'duration': 0.5}, {'force': 10.0}),
    ('swinging_load', {'mass': 0.5, 'frequency': 1.3}, {'frequency': 1.3}),
    ('cable_drag', {'torque': 3.0}, {})])
def test_what_an_effect_adds_is_read_off_the_plant(name, parameters, expected):
    entry = {'name': name, 'parameters': parameters}
    if EFFECTS[name].per_joint:
        entry['joints'] = [JOINT]
    assert true_change(ur10e(), PLANT, entry) == pytest.approx(expected)


def test_comparable_figures_are_figures_of_the_models_effects():
    from hand_load_estimator.effects import EFFECTS as MODEL_EFFECTS
    for name in set(COMPARABLE) - set(IN_REPORT_ONLY):
        effect, figures = MODEL_EFFECTS[name], COMPARABLE[name]
        known = {p for p, _ in effect.parameters} | {shape.name for shape in effect.shapes}
        if effect.derived:
            known |= set(effect.derived(np.ones(len(effect.parameters)), effect.default_shape()))
        assert set(figures) <= known | {'travel_of_reversal'}, name


def test_what_a_diagnosis_adds_is_a_change_of_the_model():
    before = exact_model('four')
    robot, joint = before.robot, 2
    mean = before.mean.copy()
    (where,) = [w for use, w in before.slices()
                if use.name == 'viscous_friction' and use.joint == joint]
    mean[where] += 1.5
    after = replace(before, mean=mean)
    entry = {'name': 'viscous_friction', 'joints': [robot.joints[joint]]}
    assert model_change(robot, before, after, entry) == pytest.approx({'coefficient': 1.5})
    spring = {'name': 'gravity_spring', 'joints': [robot.joints[joint]]}
    uses = (*before.uses, *effect_uses(robot, ('gravity_spring',)))
    sprung = replace(before, uses=uses, mean=np.concatenate(
        [before.mean, np.tile([3.0, 4.0], robot.n)]), covariance=None)
    assert model_change(robot, before, sprung, spring) == pytest.approx({'stiffness': 5.0})
    assert model_change(robot, sprung, before, spring) == pytest.approx({'stiffness': -5.0})
    assert model_change(robot, before, after, {'name': 'load_change'}) == {}


@pytest.mark.parametrize('plastic', [0.05, 0.7, 2.0])
def test_a_reversal_of_the_model_is_the_travel_after_which_it_has_turned(plastic):
    before = exact_model('four')
    (place, use), = [(k, u) for k, u in enumerate(before.uses)
                     if u.name == 'presliding_hysteresis' and u.joint == 1]
    longer = replace(use, shape={'presliding_distance': 0.02, 'plastic': plastic})
    after = replace(before, uses=(*before.uses[:place], longer, *before.uses[place + 1:]))
    entry = {'name': 'presliding_hysteresis', 'joints': [before.robot.joints[1]]}
    travel = model_change(before.robot, before, after, entry)['travel_of_reversal'] \
        + np.log(40.0) * use.shape['presliding_distance']
    assert Turning(plastic).turned(-1.0, travel, 0.02) == pytest.approx(0.95)


def test_a_figure_is_stated_as_a_change_where_the_model_had_the_effect():
    figures = {'level': {'mean': 5.0, 'std': 0.3, 'unit': 'Nm'},
               'change_of_level': {'mean': 1.0, 'std': 0.2, 'unit': 'Nm'},
               'width': {'mean': 0.1, 'std': None, 'unit': 'rad/s'}}
    found = [stated({'parameters': figures}, name) for name in ('level', 'width', 'delay')]
    assert found == [(1.0, 0.2), (0.1, None), (None, None)]


def test_torque_error_is_what_the_model_leaves_while_joints_move():
    model = exact_model('four')
    stream = messages(model, LoadParameters(), 5.0, noisy=False, rest=2.0)
    motion, _ = motion_of(model.robot, recording_of(stream, model.robot.joints))
    evidence = prepare(model.robot, 'made up', motion, LoadParameters())
    off = np.array([0.5, 1.0, 1.5, 2.0])
    (where,) = [w for use, w in model.slices() if use.name == 'torque_offset' and use.joint == 1]
    mean = model.mean.copy()
    mean[where] -= off[1]
    clean, wrong = (torque_rmse(m, [evidence]) for m in (model, replace(model, mean=mean)))
    assert np.all(clean < 0.3 * off)
    assert wrong[1] == pytest.approx(np.hypot(off[1], clean[1]), rel=0.1)
    np.testing.assert_allclose(np.delete(wrong, 1), np.delete(clean, 1))
