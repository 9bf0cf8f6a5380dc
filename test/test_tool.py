"""A known tool and an unknown workpiece are told apart by configuration."""

from core_helpers import (block, exact_model, feed, Message, messages, swing, torque_of,
                          warm)
import numpy as np
import pytest

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.estimators.checkpoint import belongs_to
from hand_load_estimator.estimators.direct import Direct
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.estimators.tool import read_tool
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.torque.model_file import write_model

TOOL, PART = block(1.5), block(2.0, (0.0, 0.05, 0.15))


@pytest.fixture(scope='module')
def model():
    return exact_model('four')


@pytest.fixture
def pipelines(model, tmp_path):
    """Return make(std text) -> a Pipeline that knows the tool with that std."""
    write_model(tmp_path / 'm.yaml', model)

    def make(std='', mass=TOOL.mass):
        tool = tmp_path / 'tool.yaml'
        write_load_file(tool, LoadParameters(mass, TOOL.com, TOOL.inertia))
        tool.write_text(tool.read_text() + std)
        return warm(build_pipeline(tmp_path / 'm.yaml', 'bayes', tool_path=tool))
    return make


@pytest.fixture(scope='module')
def both(model):
    """Return Messages of the arm with tool and workpiece."""
    robot, times = model.robot, np.arange(500) / 100.0
    q, v, a = swing(robot, times, seed=4)
    torque = torque_of(model, q, v, a, 0.01, 25.0, [(0, TOOL)])
    torque += np.array([robot.load_regressor(*row) @ PART.to_products()
                        for row in zip(q, v, a)])
    return [Message(100.0 + t, robot.joints, *row) for t, *row in zip(times, q, v, torque)]


def test_the_estimate_is_the_workpiece_alone(pipelines, both):
    pipeline = pipelines()
    last = feed(pipeline, both)[-1]
    assert (np.abs(last.mean - PART.to_message()) < 3.5 * last.std + 1e-9)[:4].all()
    assert pipeline.tool_mass == TOOL.mass and pipeline.tared_mass == 0.0


def test_a_bare_tool_is_no_load(pipelines, model):
    last = feed(pipelines(), messages(model, TOOL, 5.0))[-1]
    assert abs(last.mean[0]) < 3.0 * last.std[0] + 0.01


def test_what_is_not_known_of_the_tool_is_not_known_of_the_workpiece(pipelines, both):
    """A tool of 0.2 kg less than stated, and stated to 0.2 kg: the interval must hold that."""
    sure = feed(pipelines(), both)[-1].std
    last = feed(pipelines('std: {mass: 0.2, com: [0.01, 0.01, 0.01]}\n', TOOL.mass + 0.2),
                both)[-1]
    assert 0.15 < last.std[0] < 0.25 and sure[0] < 0.05
    assert abs(last.mean[0] - PART.mass) < 2.0 * last.std[0]


@pytest.mark.parametrize('sure', [0.05, 0.5])
def test_nothing_is_known_better_than_the_tool_it_is_held_beside(tmp_path, sure):
    """What a network or a calibration makes of a variance was learned without a tool."""
    path = tmp_path / 'tool.yaml'
    write_load_file(path, TOOL)
    path.write_text(path.read_text() + 'std: {mass: 0.3, com: [0.01, 0.0, 0.0]}\n')
    own = Belief(PART.to_message(), sure ** 2 * (0.5 * np.eye(10) + 0.5))
    tool, light = read_tool(path), 0.1
    told, added = (tool.beside(own, counted, light).covariance for counted in (True, False))
    assert np.sqrt(told[0, 0]) == pytest.approx(max(sure, 0.3))
    assert np.sqrt(added[0, 0]) == pytest.approx(np.hypot(sure, 0.3))
    # 1.5 kg that lie 10 mm aside are as wrong as 2 kg that lie 7.5 mm aside.
    aside = 1.5 * 0.01 / PART.mass
    assert np.sqrt(added[1, 1] - sure ** 2) == pytest.approx(
        np.hypot(aside, 0.3 * (TOOL.com[0] - PART.com[0]) / PART.mass))
    assert np.linalg.eigvalsh(told)[0] > 0.0 and np.linalg.eigvalsh(added)[0] > 0.0
    if sure > 0.3:
        np.testing.assert_allclose(told, own.covariance)
    # Of nothing the place is as doubtful as that of a light load.
    nothing = Belief(np.zeros(10), own.covariance)
    assert np.isfinite(tool.beside(nothing, False, light).covariance).all()


def test_what_a_network_never_saw_of_a_tool_is_added(pipelines, both):
    pipeline = pipelines('std: {mass: 0.2}\n')
    counted = feed(pipeline, both)[-1]
    pipeline.method.counts_doubts = Direct.counts_doubts
    added = pipeline.estimate(pipeline.last_stamp + 9.0)
    assert added.std[0] == pytest.approx(np.hypot(counted.std[0], 0.2), rel=0.02)


def test_a_reset_keeps_the_tool(pipelines, both):
    pipeline = pipelines()
    pipeline.reset()
    assert abs(feed(pipeline, both)[-1].mean[0] - PART.mass) < 0.1


def test_a_checkpoint_belongs_to_its_tool(pipelines):
    assert belongs_to(pipelines()) != belongs_to(pipelines(mass=1.6))


@pytest.mark.parametrize('text, said', [
    ('mass: -1\n', 'mass'), ('mass: 1\nstd: {weight: 1}\n', 'weight'),
    ('mass: 1\n', 'gives a mass without its com'),
    ('mass: 1\nstd: {com: [1, 2]}\n', 'com'), ('mass: 1\nstd: {mass: -1}\n', 'mass'),
    ('', 'mapping')])
def test_a_wrong_tool_file_is_refused(tmp_path, text, said):
    (tmp_path / 't.yaml').write_text(text)
    with pytest.raises(ConfigurationError, match=said):
        read_tool(tmp_path / 't.yaml')


def test_a_load_file_that_says_none_is_no_tool(tmp_path, model):
    write_model(tmp_path / 'm.yaml', model)
    (tmp_path / 't.yaml').write_text('none\n')
    pipeline = build_pipeline(tmp_path / 'm.yaml', 'bayes', tool_path=tmp_path / 't.yaml')
    assert pipeline.tool is None and pipeline.tool_mass == 0.0


def test_a_tool_without_mass_needs_no_place(tmp_path):
    (tmp_path / 't.yaml').write_text('mass: 0\n')
    assert read_tool(tmp_path / 't.yaml').mass == 0.0
