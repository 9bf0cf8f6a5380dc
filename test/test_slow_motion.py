"""An arm that creeps along tells of its load like any other, once friction has turned."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
from pipeline_helpers import within
import pytest

from hand_load_estimator.estimators.regression import moves, MOVING

MASS = 3.0


@pytest.mark.parametrize('other', [None, 3.2])
def test_a_load_exchanged_while_the_arm_creeps_is_seen(other):
    """No piece of data ended below 0.02 rad/s: the old load stayed, surer and surer."""
    model = exact_model('four')
    pipeline = warm(pipeline_of(model))
    assert feed(pipeline, messages(model, block(MASS), 6.0))[-1].status == 'DETERMINED'
    creeping = messages(model, block(MASS), 15.0, seed=1, size=0.004,
                        change=(10.0, block(other)) if other else None)
    assert max(np.abs(m.velocity).max() for m in creeping) < 0.023
    estimates = feed(pipeline, [replace(m, stamp=m.stamp + 7.0) for m in creeping])
    assert pipeline.load_id == (other is not None)
    assert within(estimates[-1], block(other or MASS))
    early = [e for e in estimates if e.stamp < creeping[0].stamp + 17.0]
    assert {e.load_id for e in early} == {0}


def test_a_joint_in_motion_moves_whatever_its_friction_does():
    one = np.array([0.0, 1.0])
    assert moves(SimpleNamespace(v=2.0 * MOVING * one), SimpleNamespace(z=0.1 * one, doubt=one))


@pytest.mark.parametrize('v, z, doubt, wanted', [
    (0.01, 0.99, 0.01, True), (0.01, -0.99, 0.01, True), (0.001, 0.99, 0.01, False),
    (0.01, 0.9, 0.01, False), (0.01, 0.99, 1.0, False)])
def test_what_is_held_or_turns_around_does_not_creep(v, z, doubt, wanted):
    assert v < MOVING
    one = np.array([0.0, 1.0])
    sample, prediction = SimpleNamespace(v=v * one), SimpleNamespace(
        z=z * one, doubt=doubt * one)
    assert moves(sample, prediction) == wanted
