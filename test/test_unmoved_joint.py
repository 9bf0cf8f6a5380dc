"""A joint that no recording moved: its friction is not known, and what it holds says nothing."""

import core_helpers
from core_helpers import block, exact_model, feed, messages, pipeline_of, recording_of, swing, warm
import numpy as np
import pytest

from hand_load_estimator.evidence import prepare
from hand_load_estimator.identification import identify
from hand_load_estimator.identified_sense import nonsense
from hand_load_estimator.joint_stream import motion_of
from hand_load_estimator.load import LoadParameters

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


@pytest.mark.parametrize('held', [0.01, 0.03])
def test_what_it_holds_is_no_load(arm, model, held):
    held *= model.robot.limits.torque[STILL]
    pipeline = warm(pipeline_of(model))
    estimates = feed(pipeline, arm(block(2.0), 7, 10.0, held))
    assert held > 3.0 * model.noise[STILL]
    assert pipeline.load_id == 0 and not any(
        e.status == 'MODEL_MISMATCH' for e in estimates)
    mean, std = estimates[-1].mean[0], estimates[-1].std[0]
    assert abs(mean - 2.0) < 3.0 * std < 0.3


def test_its_friction_is_as_unknown_as_that_of_any_joint(model):
    level, held = model.friction_level(), model.held_friction()
    assert level[STILL] < 0.2 * held[STILL]
    moved = np.arange(model.robot.n) != STILL
    np.testing.assert_allclose(held[moved], level[moved], rtol=0.02)


def test_it_is_told(model, evidence):
    told = [text for text in nonsense(model, evidence) if 'moved' in text]
    assert len(told) == 1 and told[0].startswith(f'{model.robot.joints[STILL]}: ')
