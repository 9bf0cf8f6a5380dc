"""A joint that no recording moved: its friction is not known, and what it holds says nothing."""

import core_helpers
from core_helpers import block, exact_model, feed, messages, pipeline_of, recording_of, swing, warm
import numpy as np
import pytest

from hand_load_estimator.control.collision_threshold import CollisionThresholds
from hand_load_estimator.control.load_belief import rated_belief
from hand_load_estimator.evidence import prepare
from hand_load_estimator.identification import identify
from hand_load_estimator.identified_sense import nonsense
from hand_load_estimator.joint_stream import motion_of
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.nodes.controller_report import report_torque_model
from hand_load_estimator.nodes.diagnostics import WARN
from hand_load_estimator.nodes.model_cautions import cautions

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


@pytest.fixture(scope='module')
def evidence(arm):
    """Two recordings without load."""
    robot = exact_model('four').robot
    made = [recording_of(arm(LoadParameters(), seed, 25.0), robot.joints) for seed in (1, 2)]
    return [prepare(robot, f'run {k}', motion_of(robot, recording)[0], LoadParameters(), recording)
            for k, recording in enumerate(made)]


@pytest.fixture(scope='module')
def model(evidence):
    """The model identified from them."""
    return identify(exact_model('four').robot, evidence)


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
    assert model.noise[STILL] == model.friction_doubt()[STILL] > 0.03 * model.robot.limits.torque[
        STILL]
    moved = np.arange(model.robot.n) != STILL
    assert (model.noise < 0.01 * model.robot.limits.torque)[moved].all()


def test_a_held_torque_is_no_collision(model):
    """The controller's threshold for a joint that stands reaches to what its friction may hold."""
    still, belief = np.zeros(model.robot.n), rated_belief(model.robot)
    _, fixed = CollisionThresholds(model).at(still, still, still, belief, still + 25.0)
    assert fixed[STILL] > 0.03 * model.robot.limits.torque[STILL]


def test_nodes_tell_it(model):
    told, = cautions(model, True)
    assert f'the friction of {model.robot.joints[STILL]} is not known' in told
    assert report_torque_model(model, True)[:2] == (WARN, told)
    assert cautions(exact_model('four'), True) == []


def test_it_is_told(model, evidence):
    told = [text for text in nonsense(model, evidence) if 'moved' in text]
    assert len(told) == 1 and told[0].startswith(f'{model.robot.joints[STILL]}: ')
