"""Effects that look alike: known pairs, the motion that tells them apart, and where none does."""

from pathlib import Path
import re
from types import SimpleNamespace

import numpy as np
from plant_helpers import ur10e
import pytest

from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.residual.diagnosis import Alternative
from hand_load_estimator.residual.findings import alternatives_of, separating_motion
from hand_load_estimator.residual.tracing.candidate import Candidate, Step
from hand_load_estimator.residual.tracing.confusable import (advice, NO_KNOWN_MOTION, NO_MOTION,
                                                             PAIRS, partners)
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis
from hand_load_estimator.residual.tracing.one_torque import is_its_link, weight_is_its_own
from hand_load_estimator.robot import robot_from_content


def test_pairs_of_the_design_are_known_with_a_motion():
    for pair in (('gravity_spring', 'link_inertia'), ('gravity_spring', 'cable_drag'),
                 ('presliding_hysteresis', 'stribeck_friction'),
                 ('temperature_dependent_coulomb_friction',
                  'temperature_dependent_viscous_friction'), ('base_tilt', 'link_inertia')):
        assert pair[1] in partners(pair[0]) and pair[0] in partners(pair[1])
        assert len(advice(pair[0], [pair[1]])) > 20
        assert advice(*pair[:1], [pair[1]]) == advice(pair[1], [pair[0]])


@pytest.mark.parametrize('pair', sorted(map(sorted, PAIRS)))
def test_every_pair_has_a_motion_either_way(pair):
    first, second = pair
    assert {first, second} <= set(EFFECTS) | {'link_inertia'}
    assert advice(first, [second]) == advice(second, [first]) == PAIRS[frozenset(pair)]
    assert NO_KNOWN_MOTION not in advice(first, [second]) and second in partners(first)


def test_advice_says_so_where_no_motion_is_known():
    assert advice('torque_ripple', []) == ''
    assert advice('friction_asymmetry', ['viscous_friction']) == (
        f'{NO_KNOWN_MOTION} viscous_friction')
    both = advice('friction_asymmetry', ['torque_offset', 'viscous_friction'])
    assert both.startswith('reverse the joint') and both.endswith(f'{NO_KNOWN_MOTION} '
                                                                  'viscous_friction')
    assert 'in several poses' in advice('cable_drag', ['base_tilt'])
    # Its own name on other joints is no effect to be told from.
    assert advice('cable_drag', ['cable_drag']) == ''
    assert 'joint between both links' in advice('link_inertia', ['link_inertia'])


def test_what_follows_different_variables_is_told_apart_by_them():
    told = advice('coulomb_friction', ['base_tilt'])
    assert told.startswith('coulomb_friction follows velocity, base_tilt position: move so')


def test_a_weight_that_nothing_turns_is_told_from_a_cable_by_its_sine():
    """Turning the first joint of an upright arm changes nothing at the second."""
    for own_weight, motion in ((True, 'a whole turn'), (False, 'in several poses')):
        assert motion in advice('link_inertia', ['cable_drag'], own_weight)
    arm = ur10e()
    assert [weight_is_its_own(arm, j) for j in range(5)] == [True, True, False, False, False]


def test_nobody_is_told_to_hold_still():
    """At rest friction hides everything, and recordings that only hold are refused."""
    assert not any('still' in motion for motion in PAIRS.values())


def test_what_is_left_open_on_measured_arms_has_a_motion():
    page = Path(__file__).parents[1] / 'doc' / 'benchmark' / 'real-diagnosis.md'
    groups = [re.findall('`(.*?)`', group) for group in
              re.findall('(`[a-z_]+`(?: or `[a-z_]+`)+)', page.read_text('utf-8'))]
    assert len(groups) > 3
    for name, *others in groups:
        assert NO_KNOWN_MOTION not in advice(name, others)


@pytest.mark.parametrize('name', ['rotor_inertia', 'gravity_spring'])
def test_what_only_the_link_of_its_joint_can_be_told_from_by_no_motion(name):
    """Of an upright arm that is the second joint's spring and rotor, of others it is not."""
    robot, rng = ur10e(), np.random.default_rng(3)
    motions = rng.normal(size=(3, 60, robot.n))
    x = SimpleNamespace(q=motions[0], v=motions[1], a=motions[2])
    same = [is_its_link(name, j, robot, x) for j in range(5)]
    assert same == [name == 'rotor_inertia', True, False, False, False]


@pytest.mark.parametrize('gravity', [[0.0, 0.0, -9.81], [0.5, 0.0, -9.8]])
def test_a_rotor_and_the_inertia_of_the_first_link_are_one_to_recordings(gravity):
    robot, rng = robot_from_content({**ur10e().file.content, 'gravity': gravity}, 'arm'), \
        np.random.default_rng(4)
    motions = [rng.normal(size=(3, robot.n)) for _ in range(50)]
    links = np.array([robot.link_regressor(*qva) for qva in motions])
    acceleration = np.array([[a[0]] for _, _, a in motions])
    q, v, a = np.swapaxes(motions, 0, 1)
    cold = SimpleNamespace(warmth=np.zeros((50, robot.n)), q=q, v=v, a=a)
    residual = SimpleNamespace(columns=links, x=cold)
    rotor = Hypothesis('rotor_inertia', 0, {0: acceleration}, np.ones(1))
    chosen = Candidate('rotor_inertia', ((rotor, None),), 1.0, 1.0, np.ones(1))
    assert separating_motion(robot, residual, chosen, ()).startswith(NO_MOTION)
    # Nobody chose the first link: it gains what the rotor does, and is named all the same.
    others = alternatives_of(robot, residual, Step(chosen, (), None, 1.0))
    assert others == (Alternative('link_inertia', (robot.joints[0],), 0.0, 0.0),)
    # Another link is something else, and told from the rotor as ever.
    told = separating_motion(robot, residual, chosen, ['link_inertia'])
    assert told.endswith(advice('rotor_inertia', ['link_inertia']))


@pytest.mark.parametrize('warmth, told', [
    ((12.0, 14.0), True), ((12.0, 20.0), False), ((-1.0, 1.0), False), ((-14.0, -13.0), True)])
def test_at_one_temperature_friction_and_its_change_with_it_are_one(warmth, told):
    """Parameters are stated at warmth 0: there it is the plain one, as where none is known."""
    robot, part = ur10e(), Hypothesis('coulomb_friction', 1, {1: np.ones((50, 1))}, np.ones(1))
    residual = SimpleNamespace(columns=np.zeros((50, robot.n, 60)), x=SimpleNamespace(
        warmth=np.tile(np.linspace(*warmth, 50)[:, None], (1, robot.n))))
    other = 'temperature_dependent_coulomb_friction'
    chosen = Candidate('coulomb_friction', ((part, None),), 1.0, 1.0, np.ones(1))
    found = alternatives_of(robot, residual, Step(chosen, (), None, 1.0))
    assert found == ((Alternative(other, (robot.joints[1],), 0.0, 0.0),) if told else ())
    assert separating_motion(robot, residual, chosen, ()) \
        == advice('coulomb_friction', [other] if told else [])
    assert not alternatives_of(robot, residual, Step(
        Candidate('cable_drag', ((part, None),), 1.0, 1.0, np.ones(1)), (), None, 1.0))


def test_the_last_link_is_not_told_from_a_load_that_nobody_declared():
    robot = ur10e()
    residual = SimpleNamespace(x=SimpleNamespace(warmth=np.zeros((50, robot.n))))
    for j, both in ((robot.n - 1, True), (robot.n - 2, False)):
        part = Hypothesis('link_inertia', j, {j: np.ones((50, 10))}, np.ones(10))
        chosen = Candidate('link_inertia', ((part, None),), 1.0, 1.0, np.ones(1))
        found = alternatives_of(robot, residual, Step(chosen, (), None, 1.0))
        assert found == ((Alternative('undeclared_load', (robot.joints[j],), 0.0, 0.0),)
                         if both else ())
        assert ('take everything off the hand' in separating_motion(
            robot, residual, chosen, ())) == both
