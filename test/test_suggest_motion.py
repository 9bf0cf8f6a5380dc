"""The suggested motion is small, within the limits, and does what is said of it."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import block, exact_model, feed, Message, messages, pipeline_of, torque_of, warm
import numpy as np
import pytest

from hand_load_estimator.estimators.build import determined_std
from hand_load_estimator.estimators.information import as_stated, Trust
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.estimators.suggest_motion import MotionSuggester, SuggestionError
from hand_load_estimator.estimators.tool import Tool
from hand_load_estimator.load import LoadParameters, MESSAGE_ORDER

POSE = np.array([0.0, -1.2, 1.5, -0.5, -1.0, 0.3])
WARM = np.full(6, 25.0)


@pytest.fixture(scope='module')
def model():
    return exact_model('ur10e')


def determined(model):
    """Return the std (10,) below which parameters count as determined."""
    return np.repeat(determined_std(model.robot), (1, 3, 6))


def standing(model, load, pose=POSE, seconds=1.0):
    """Return a pipeline of an arm that has stood at a pose with a load."""
    pipeline = warm(pipeline_of(model))
    feed(pipeline, moved(model, load, np.arange(int(100 * seconds)) / 100.0,
                         lambda t: (np.tile(pose, (len(t), 1)), *np.zeros((2, len(t), 6)))))
    return pipeline


def moved(model, load, times, motion, seed=1):
    """Return Messages of a motion(times) -> q, v, a with white noise on the torque."""
    q, v, a = motion(times)
    torque = torque_of(model, q, v, a, 0.01, 25.0, [(0, load)])
    torque += np.random.default_rng(seed).normal(size=torque.shape) * 0.005 \
        * model.robot.limits.torque
    return [Message(100.0 + t, model.robot.joints, *row)
            for t, *row in zip(times, q, v, torque)]


@pytest.mark.parametrize('mass', [3.0, 8.0])
def test_following_it_settles_what_it_says(model, mass):
    pipeline = standing(model, block(mass))
    suggestion = pipeline.suggest_motion(pipeline.last_stamp)
    assert set('mxyz') <= set(suggestion.undetermined)
    assert suggestion.settled[:1] == ('m',) and suggestion.trajectory is not None
    motion = suggestion.trajectory
    times = np.arange(0.01, motion.duration + 0.2, 0.01)
    stream = moved(model, block(mass), times, motion.sample)
    estimates = feed(pipeline, [replace(m, stamp=m.stamp + 1.0) for m in stream])
    last = estimates[-1]
    for name in suggestion.settled:
        assert last.determined[MESSAGE_ORDER.index(name)], name
    assert (last.std[:4] < 1.5 * suggestion.std[:4]).all()
    assert (np.abs(last.mean - block(mass).to_message())[:4] < 3.5 * last.std[:4]).all()


def test_it_stays_within_the_limits_and_ends_where_it_began(model):
    limits = model.robot.limits
    pipeline = standing(model, block(6.0))
    suggestion = pipeline.suggest_motion(pipeline.last_stamp)
    q, v, a = suggestion.trajectory.sample(np.linspace(0.0, suggestion.trajectory.duration, 400))
    assert (q > limits.lower).all() and (q < limits.upper).all()
    assert (np.abs(v) <= 0.85 * limits.velocity).all()
    assert (np.abs(a) <= 0.75 * limits.acceleration).all()
    np.testing.assert_allclose(q[0], POSE, atol=1e-5)
    np.testing.assert_allclose(q[-1], POSE, atol=1e-5)
    for row in zip(q[::20], v[::20], a[::20]):
        torque = model.robot.rigid_torque(*row, model.robot.rated_load)
        assert (np.abs(torque) <= limits.allowed_torque * limits.torque).all()
    names = {joint for joint, _ in suggestion.moves}
    assert [joint in names for joint in model.robot.joints] == list(np.ptp(q, axis=0) > 1e-6)


def test_less_is_asked_for_where_less_is_open(model):
    """Thresholds a quarter as wide need a larger motion."""
    pipeline = standing(model, block(6.0))
    wide = determined(model)

    def travel(thresholds):
        suggestion = MotionSuggester(model, thresholds).suggest(pipeline.method, POSE, WARM)
        return sum(abs(amplitude) for _, amplitude in suggestion.moves)
    assert 0.0 < travel(wide) < travel(0.25 * wide)


def test_what_is_not_known_of_the_tool_stays_open(model):
    """The same motions tell no more of the load than is known of what is held beside it."""
    method, mass = standing(model, block(6.0)).method, np.eye(10)[:, :1]
    prior = method.belief().covariance[0, 0]
    for std in (1e-3, 0.5):
        tool = Tool(block(2.0).to_products(), std * mass)
        trust = as_stated(len(method.trusted.precision) + 1)
        suggestion = MotionSuggester(model, determined(model), tool).suggest(
            SimpleNamespace(belief=method.belief, tared=method.tared, trusted=trust), POSE, WARM)
        # Its place is assumed a little, which with m c tells a little of its mass, too.
        least = 0.95 * (1.0 / prior + 1.0 / std ** 2) ** -0.5
        assert least < suggestion.std[0] < prior ** 0.5
        assert ('m' in suggestion.settled) == (std < 0.01)


def test_a_model_that_is_trusted_less_asks_for_more(model):
    """A friction level that may be anything, and a base that may lean by any angle."""
    method = standing(model, block(6.0)).method
    precision = method.trusted.precision.diagonal().copy()
    precision[:2] = precision[-12:-6] = 1e-8

    def travel(trust):
        suggestion = MotionSuggester(model, determined(model)).suggest(SimpleNamespace(
            belief=method.belief, tared=method.tared, trusted=trust), POSE, WARM)
        return sum(abs(amplitude) for _, amplitude in suggestion.moves)
    stated = travel(method.trusted)
    assert travel(Trust(np.diag(precision))) > stated
    assert travel(Trust(method.trusted.precision, 9.0)) > stated


def test_words_name_what_is_open_and_what_would_settle_it(model):
    pipeline = standing(model, block(6.0))
    text = pipeline.suggest_motion(pipeline.last_stamp).text()
    assert text.startswith('not determined: mass ') and 'move ' in text and 'and back in' in text
    assert 'expected std after it: mass 0.' in text


def test_nothing_is_suggested_for_what_no_motion_settles(model):
    """An empty hand's load has no place, however it is moved."""
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, LoadParameters(), 6.0))
    empty = Belief(np.zeros(10), pipeline.method.belief().covariance)
    thresholds = np.r_[10.0, 1e-6, 1e-6, 1e-6, np.full(6, 10.0)]
    suggestion = MotionSuggester(model, thresholds).suggest(
        SimpleNamespace(belief=lambda: empty, tared=np.zeros(10), trusted=pipeline.method.trusted),
        POSE, WARM)
    assert suggestion.undetermined == ('x', 'y', 'z') and suggestion.trajectory is None
    assert 'no motion' in suggestion.text()


def test_it_is_refused_where_the_arm_may_be_elsewhere_by_now(model):
    pipeline = standing(model, block(2.0))
    with pytest.raises(SuggestionError, match='no usable joint state for 300.00 s'):
        pipeline.suggest_motion(pipeline.last_stamp + 300.0)


def test_it_is_refused_before_data_and_while_moving(model):
    with pytest.raises(SuggestionError, match='no usable joint states'):
        pipeline_of(model).suggest_motion(0.0)
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, block(2.0), 1.5))
    with pytest.raises(SuggestionError, match='moves'):
        pipeline.suggest_motion(pipeline.last_stamp)
