"""Innovations larger than stated widen intervals at once, those as stated do not."""

from types import SimpleNamespace

from core_helpers import block, exact_model, four_axes, messages, pipeline_of
from lstm_helpers import artefact_of, network_of, pipeline_with
import numpy as np
import pytest

from hand_load_estimator.estimators.innovation_scale import EXCESS, InnovationScale

RMSE = np.array([0.5, 1.0, 2.0])


def scaled(times, seconds, factor=1.0, moves=(True, True, True), seed=3):
    """Return what variances grow by after innovations so many times (3,) as large as stated."""
    scale, rng = InnovationScale(RMSE), np.random.default_rng(seed)
    v = np.where(moves, 0.5, 0.0)
    for _ in range(int(seconds / 0.02)):
        scale.update(times * RMSE * rng.normal(size=3), np.zeros(3),
                     SimpleNamespace(dt=0.02, v=v))
    return scale.beyond(factor)


@pytest.mark.parametrize('seconds', [0.0, 2.0, 10.0])
@pytest.mark.parametrize('times', [0.1, 0.7, 1.0])
def test_innovations_as_stated_widen_nothing(times, seconds):
    grown = [scaled(np.full(3, times), seconds, seed=seed) for seed in range(20)]
    assert np.mean(grown) < 1.1 and max(grown) < 2.0


def test_the_joint_that_differs_most_counts():
    """The excess of its mean square over what is expected, several times."""
    grown = scaled(np.array([0.5, 4.0, 1.0]), 10.0)
    assert grown == pytest.approx(1.0 + EXCESS * (16.0 - 1.0), rel=0.15)
    assert scaled(np.array([0.5, 4.0, 1.0]), 0.2) > 5.0


def test_a_joint_that_stands_tells_nothing():
    assert scaled(np.array([1.0, 9.0, 1.0]), 5.0, moves=(True, False, True)) < 1.5


def test_what_the_trust_in_the_model_widens_is_not_widened_again():
    times = np.array([1.0, 3.0, 1.0])
    assert scaled(times, 5.0, factor=4.0) == pytest.approx(scaled(times, 5.0) / 4.0)
    assert scaled(times, 5.0, factor=100.0) == 1.0


@pytest.fixture(scope='module')
def silent(tmp_path_factory):
    """Return the artefact of a network that has learnt nothing."""
    robot = four_axes()
    return artefact_of(tmp_path_factory.mktemp('silent'), robot, network_of(robot, size=0.0))


def run(change=lambda k, m: m, artefact=None, rate=100.0):
    """Return the Pipeline after a run of the four-axis arm, and its last estimate."""
    model = exact_model('four')
    pipeline = pipeline_with(model, artefact) if artefact else pipeline_of(model)
    for k, m in enumerate(messages(model, block(2.0), 6.0, rate=rate)):
        m = change(k, m)
        pipeline.joint_state(m.stamp, m.names, m.position, m.velocity, m.effort)
    return pipeline, pipeline.estimate(m.stamp)


def shaken(k, m):
    """A torque that no load makes, of the first joint, which gravity does not load."""
    effort = np.array(m.effort)
    effort[0] += 1.5 * np.sin(0.4 * k)
    return SimpleNamespace(stamp=m.stamp, names=m.names, position=m.position,
                           velocity=m.velocity, effort=effort)


@pytest.mark.parametrize('learned', [False, True])
def test_the_estimate_of_an_arm_that_ails_is_told_to_be_less_sure(learned, silent):
    pipeline, ill = run(shaken, silent if learned else None)
    method = pipeline.method
    grown = method._scale.beyond(method.factor)
    assert grown > 1.3 and method.trusted.factor == pytest.approx(method.factor * grown)
    method._scale.clear()
    np.testing.assert_allclose(method.belief().covariance[0, 0] * grown, ill.covariance[0, 0],
                               rtol=0.05)


def test_the_noise_of_a_slow_driver_is_not_blamed_on_the_model():
    """The model states the residual of 100 Hz; at 30 Hz samples have more of the same noise."""
    pipeline, _ = run(rate=30.0)
    assert pipeline.method._scale.beyond(1.0) < 1.5


def test_what_was_seen_is_kept_over_a_restart():
    pipeline, _ = run(shaken)
    state = pipeline.method.state()
    assert state['innovations'].any()
    other, _ = run()
    other.method.restore(state)
    np.testing.assert_array_equal(other.method.state()['innovations'], state['innovations'])
    with pytest.raises(ValueError, match='innovations is missing'):
        other.method.restore({k: v for k, v in state.items() if k != 'innovations'})


def test_another_load_is_not_blamed():
    pipeline, _ = run(shaken)
    pipeline.reset()
    assert not pipeline.method.state()['innovations'].any()
