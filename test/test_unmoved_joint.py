"""A joint that no recording moved: its friction is not known, and what it holds says nothing."""

import core_helpers
from core_helpers import (block, exact_model, feed, four_axes, message_noise, messages,
                          pipeline_of, recording_of, swing, warm)
import numpy as np
import pytest

from hand_load_estimator.control.collision_threshold import CollisionThresholds
from hand_load_estimator.control.load_belief import rated_belief
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.identification.identified_sense import nonsense
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.nodes.controller_report import report_torque_model
from hand_load_estimator.nodes.diagnostics import WARN
from hand_load_estimator.nodes.model_cautions import cautions
from hand_load_estimator.residual.add import better_model
from hand_load_estimator.stream.joint_stream import motion_of

STILL = 3


@pytest.fixture(scope='module')
def arm():
    """Messages of an arm with a joint that stands, by load, seed and the friction it holds."""
    def standing(*arguments):
        q, v, a = swing(*arguments)
        q[:, STILL], v[:, STILL], a[:, STILL] = q[0, STILL], 0.0, 0.0
        return q, v, a

    def stream(load, seed, seconds, held=0.0):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(core_helpers, 'swing', standing)
            out = messages(exact_model('four'), load, seconds, seed=seed)
        for k, message in enumerate(out):
            # The other joints' motion shakes what friction holds from one level to another.
            message.effort[STILL] += held * np.sign(np.sin(0.031 * k))
        return out
    return stream


def evidence_of(name, stream):
    """Return the Evidence of Messages without load."""
    robot = exact_model('four').robot
    recording = recording_of(stream, robot.joints)
    return prepare(robot, name, motion_of(robot, recording)[0], LoadParameters(), recording)


def of_runs(arm, seeds):
    """Return Evidence of runs without load."""
    return [evidence_of(f'run {seed}', arm(LoadParameters(), seed, 25.0)) for seed in seeds]


@pytest.fixture(scope='module')
def model(arm):
    """The model identified from two of them."""
    return identify(exact_model('four').robot, of_runs(arm, [1, 2]))


def told_of(model, stream):
    """Return a fresh pipeline's estimates of a stream, and how many changes it saw."""
    pipeline = warm(pipeline_of(model))
    return feed(pipeline, stream), pipeline.load_id


def assert_found(model, stream, mass):
    """The load is found, with an interval as of any arm, and torques and model are said to fit."""
    estimates, changes = told_of(model, stream)
    assert changes == 0 and not any(e.status == 'MODEL_MISMATCH' for e in estimates)
    mean, std = estimates[-1].mean[0], estimates[-1].std[0]
    assert abs(mean - mass) < 3.0 * std < 0.1


@pytest.mark.parametrize('held', [0.01, 0.03])
def test_what_it_holds_is_no_load(arm, model, held):
    assert_found(model, arm(block(2.0), 7, 10.0, held * model.robot.limits.torque[STILL]), 2.0)


def test_moved_at_last_it_is_no_misfit(model):
    assert_found(model, messages(exact_model('four'), block(2.0), 10.0, seed=7), 2.0)


def test_its_friction_is_as_unknown_as_that_of_any_joint(model):
    level, held = model.friction_level(), model.held_friction()
    assert level[STILL] < 0.2 * held[STILL]
    moved = np.arange(model.robot.n) != STILL
    np.testing.assert_allclose(held[moved], level[moved], rtol=0.02)


def test_it_leaves_as_much_as_is_not_known_of_its_friction(model):
    doubt = model.friction_doubt()[STILL]
    assert doubt <= model.noise[STILL] < 1.1 * doubt
    assert doubt > 0.03 * model.robot.limits.torque[STILL]
    moved = np.arange(model.robot.n) != STILL
    assert (model.noise < 0.01 * model.robot.limits.torque)[moved].all()


def test_a_held_torque_is_no_collision(model):
    """The controller's threshold for a joint that stands reaches to what its friction may hold."""
    still, belief = np.zeros(model.robot.n), rated_belief(model.robot)
    _, fixed = CollisionThresholds(model).at(still, still, still, belief, still + 25.0)
    assert fixed[STILL] > 2.0 * model.held_friction()[STILL]


def test_a_diagnosis_that_does_not_move_it_either_leaves_it_as_it_was(model, arm):
    """Again and again: what is known of a joint does not fade because nobody looks."""
    known = model
    for seed in (3, 4, 5):
        known = better_model(known, (), of_runs(arm, [seed]))
    still = known.residuals.unmoved
    assert list(still) == list(model.residuals.unmoved) == [j == STILL for j in range(4)]
    assert known.noise[STILL] == model.noise[STILL]
    assert known.friction_doubt()[STILL] < 1.01 * model.friction_doubt()[STILL]


def test_once_it_is_moved_it_is_known(model):
    stream = messages(exact_model('four'), LoadParameters(), 25.0, seed=3)
    moved = [evidence_of('moved', stream)]
    known = better_model(model, (), moved)
    assert not known.residuals.unmoved.any() and cautions(known, True) == []
    assert known.friction_doubt()[STILL] < 0.5 * model.friction_doubt()[STILL]
    # What nobody had seen of it is no noise any more.
    residuals = known.residuals
    assert known.noise[STILL] < 0.05 * model.noise[STILL]
    assert residuals.intensity[STILL] < 0.05 * model.residuals.intensity[STILL]
    assert nonsense(known, moved) == {}


def test_behind_a_torque_sensor_a_standing_joint_tells_its_noise(arm):
    robot = four_axes(effort={'kind': 'link_torque', 'includes_configured_load': False})
    noise, seen = message_noise(robot)[STILL], of_runs(arm, [1, 2])
    model = identify(robot, seen, ['link_inertia', 'torque_offset'])
    assert model.residuals.unmoved[STILL] and model.friction_doubt()[STILL] == 0.0
    # The motion filter leaves a share of a message's noise.
    assert 0.2 * noise < model.noise[STILL] < noise
    assert cautions(model, True) == []


def test_nodes_and_identify_tell_it(model):
    told, = cautions(model, True)
    assert told.startswith(f'the friction of {model.robot.joints[STILL]} is not known')
    assert report_torque_model(model, True)[:2] == (WARN, told)
    assert cautions(exact_model('four'), True) == []
