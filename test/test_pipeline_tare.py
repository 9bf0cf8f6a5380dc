"""Tare of the whole estimator: what is held becomes zero, with the doubt it was known with."""

from dataclasses import replace

from core_helpers import (block, exact_model, feed, Message, messages, pipeline_of, swing,
                          torque_of, warm)
import numpy as np
from pipeline_helpers import within
import pytest

from hand_load_estimator.estimators.pipeline import TareError


@pytest.fixture(scope='module')
def model():
    return exact_model('four')


def tared(model, held, seconds=5.0):
    """Return a pipeline that was tared while holding a load, and the stamp of it."""
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, held, seconds))
    pipeline.tare(pipeline.last_stamp)
    return pipeline


def test_tare_makes_what_is_held_zero(model):
    pipeline = tared(model, block(1.5))
    same = [replace(m, stamp=m.stamp + 5.5) for m in messages(model, block(1.5), 4.0, seed=1)]
    last = feed(pipeline, same)[-1]
    assert abs(last.mean[0]) < 3.0 * last.std[0] + 0.01 and last.std[0] < 0.1
    assert pipeline.load_id == 0


@pytest.mark.parametrize('moved', [False, True])
def test_what_is_only_assumed_is_no_zero(model, moved):
    pipeline = pipeline_of(model)
    if moved:
        feed(pipeline, messages(model, block(2.0), 0.3))
    with pytest.raises(TareError, match='not determined: (NO_DATA|ESTIMATING|WAITING)'):
        pipeline.tare(pipeline.last_stamp or 0.0)
    assert pipeline.tared_mass == 0.0
    feed(pipeline, [replace(m, stamp=m.stamp + 1.0) for m in messages(model, block(2.0), 8.0)])
    with pytest.raises(TareError, match='STALE_INPUT'):
        pipeline.tare(pipeline.last_stamp + 2.0)
    pipeline.tare(pipeline.last_stamp)
    assert pipeline.tared_mass == pytest.approx(2.0, abs=0.1)


def test_tare_while_standing_is_no_change_of_load(model):
    """Tare is asked for at rest: the torque the estimator looks at jumps, the arm's does not."""
    model = exact_model('ur10e')
    held, pipeline = block(11.0), warm(pipeline_of(model))
    feed(pipeline, messages(model, held, 4.0))
    still = [replace(m, stamp=m.stamp + 5.0) for m in messages(model, held, 4.0, rest=9.0)]
    feed(pipeline, still[:200])
    pipeline.tare(pipeline.last_stamp)
    estimates = feed(pipeline, still[200:])
    assert pipeline.load_id == 0
    assert abs(estimates[-1].mean[0]) < 3.5 * estimates[-1].std[0] + 0.01


def test_after_tare_only_what_is_added_counts(model):
    tool, part = block(1.5), block(2.0, (0.0, 0.05, 0.15))
    pipeline = tared(model, tool)
    robot = model.robot
    times = np.arange(500) / 100.0
    q, v, a = swing(robot, times, seed=4)
    torque = torque_of(model, q, v, a, 0.01, 25.0, [(0, tool)])
    torque += np.array([robot.load_regressor(*row) @ part.to_products()
                        for row in zip(q, v, a)])
    both = [Message(105.5 + t, robot.joints, *row) for t, *row in zip(times, q, v, torque)]
    last = feed(pipeline, both)[-1]
    assert within(last, part)
    assert last.std[0] > 0.0


@pytest.mark.parametrize('seed', range(4))
def test_tare_keeps_its_own_doubt(model, seed):
    """What was tared too early is not known; later data may not pretend that it is."""
    stds = []
    for seconds in (1.2, 5.0):
        pipeline = warm(pipeline_of(model))
        feed(pipeline, messages(model, block(1.5), seconds, seed=seed))
        pipeline.method.tare()
        last = feed(pipeline, [replace(m, stamp=m.stamp + 5.5) for m in
                               messages(model, block(1.5), 4.0, seed=seed + 10)])[-1]
        assert abs(last.mean[0]) < 3.5 * last.std[0]
        stds.append(last.std[0])
    assert stds[0] > 1.2 * stds[1]


def test_tare_keeps_the_doubt_that_was_published(model):
    """Torques that vary more than the model states make what is tared as much less known."""
    pipeline = warm(pipeline_of(model))
    rough = [replace(m, effort=m.effort + model.noise * np.sin(
        7.0 * m.stamp + np.arange(4))) for m in messages(model, block(1.5), 6.0)]
    last = feed(pipeline, rough)[-1]
    method = pipeline.method
    assert 1.5 < method.factor < 5.0
    stated = method._regression.posterior.products_covariance
    method.tare()
    assert method._regression._tare[0, 0] == pytest.approx(last.covariance[0, 0], rel=0.05)
    assert method._regression._tare[0, 0] > 1.2 * stated[0, 0]
