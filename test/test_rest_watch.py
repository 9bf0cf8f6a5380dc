"""A standing arm: another load is told from a joint that sticks."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
import pytest

from hand_load_estimator.estimators.rest_watch import (ANOTHER_LOAD, MARGIN, NOTHING, RestWatch,
                                                       SHOWS, SIGMAS, STICKS)
from hand_load_estimator.load import LoadParameters

MOVED = 4.5  # [s]


def still(joints):
    return SimpleNamespace(v=np.zeros(joints), a=np.zeros(joints), dt=0.02)


def told(usual, innovation, friction=10.0):
    """Return what a RestWatch makes of an innovation where a usual load makes such torques."""
    usual, innovation = np.array(usual, float), np.array(innovation, float)
    n = len(usual)
    watch = RestWatch(tuple('abcd')[:n], np.zeros(n), np.eye(10))
    columns = np.zeros((n, 10))
    columns[:, 0] = usual
    prediction = SimpleNamespace(friction=np.full(n, friction), load_columns=columns)
    said = [watch.update(still(n), innovation, np.zeros(n), prediction) for _ in range(5)]
    assert said[:4] == [NOTHING] * 4, 'it has not lasted yet'
    assert bool(watch.reason) == (said[4] == STICKS)
    return said[4]


@pytest.mark.parametrize('usual, innovation, what', [
    ((30.0, 30.0), (14.0, 14.0), ANOTHER_LOAD),
    # In the second half as much as may hide, where as much as hides would be.
    ((30.0, 30.0), (14.0, 1.1 * SHOWS * 13.0), ANOTHER_LOAD),
    ((30.0, 30.0), (14.0, 0.9 * SHOWS * 13.0), STICKS),
    # No other joint would show it: a prismatic axis that alone carries the weight.
    ((30.0, 0.0, 0.0), (14.0, 0.0, 0.0), ANOTHER_LOAD),
    ((30.0, 10.0), (-14.0, 0.0), ANOTHER_LOAD),
    ((30.0,), (14.0,), ANOTHER_LOAD),
    # No load turns the first joint, or so far.
    ((0.0, 30.0), (14.0, 0.0), STICKS),
    ((3.0, 0.0), (14.0, 0.0), STICKS),
    ((3.0, 30.0), (14.0, 14.0), STICKS)])
def test_a_load_shows_wherever_it_would(usual, innovation, what):
    assert told(usual, innovation) == what


def test_a_joint_that_sticks_is_named_until_it_moves_or_lets_go():
    watch = RestWatch(('pan', 'lift'), np.zeros(2), np.eye(10))
    prediction = SimpleNamespace(friction=np.array([10.0, 10.0]), load_columns=np.zeros((2, 10)))

    def after(innovation, **motion):
        sample = SimpleNamespace(**{**vars(still(2)), **motion})
        for _ in range(8):
            watch.update(sample, np.array(innovation), np.zeros(2), prediction)
        return watch.reason
    assert after([16.0, 0.0]).startswith('pan holds 16.0 Nm more than load and friction explain')
    assert after([12.0, 0.0]) == ''
    assert after([-14.0, 0.0]).startswith('pan holds 14.0 Nm')
    assert after([16.0, 0.0], v=np.array([0.1, 0.0])) == ''


def sticking(joint, load):
    """
    Return messages of an arm that moves, stands, and whose joint then holds more than stated.

    Not so much more that it could only be a contact.
    """
    model = exact_model('ur10e')
    held = (MARGIN * model.held_friction() + 2.0 * SIGMAS * model.noise) * np.eye(6)[joint]
    effort = held / model.robot.effort.torque_constants
    return messages(model, load, 4.0) + [
        replace(m, stamp=m.stamp + MOVED, effort=m.effort + effort * (102.0 < m.stamp < 104.0))
        for m in messages(model, load, 7.0, seed=1, rest=4.0)]


@pytest.mark.parametrize('load', [LoadParameters(), block(9.0)])
@pytest.mark.parametrize('joint', range(6))
def test_a_joint_that_sticks_is_no_other_load(joint, load):
    pipeline = warm(pipeline_of(exact_model('ur10e')))
    estimates = feed(pipeline, sticking(joint, load))
    assert pipeline.load_id == 0
    stands = [e for e in estimates if 102.3 < e.stamp - MOVED < 103.8]
    name = pipeline.model.robot.joints[joint]
    assert {e.status for e in stands} == {'MODEL_MISMATCH'}
    assert all(name in e.reason for e in stands), {e.reason for e in stands}
    last = estimates[-1]
    assert last.status in ('ESTIMATING', 'DETERMINED')
    assert abs(last.mean[0] - load.mass) < 3.5 * last.std[0] and last.std[0] < 0.1


def test_a_joint_that_stuck_is_forgotten_with_the_load():
    pipeline = warm(pipeline_of(exact_model('ur10e')))
    feed(pipeline, [m for m in sticking(1, block(9.0)) if m.stamp < 103.5 + MOVED])
    assert 'it sticks' in pipeline.method.mismatch
    pipeline.reset()
    assert pipeline.method.mismatch == ''
