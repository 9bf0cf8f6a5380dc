"""A mass that no load has is a mismatch of the model or the tool, not an answer."""

from dataclasses import replace

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
import pytest

from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.estimators.impossible_mass import impossible_mass
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.estimators.pipeline import TareError
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.torque.model_file import write_model

EMPTY = block(1e-6)


@pytest.mark.parametrize('mass, tared, told', [
    (-1.4, 0.0, False), (-1.6, 0.0, True), (3.0, 0.0, False),
    # After a tare what was put down is rightly missing.
    (-5.0, 5.0, False), (-7.0, 5.0, True)])
def test_only_what_no_load_weighs_is_told(mass, tared, told):
    belief = Belief(np.array([mass, *[0.0] * 9]), np.diag([0.25, *[0.01] * 9]))
    said = impossible_mass(belief, tared)
    assert ('no load weighs less than nothing' in said) == told == bool(said)


def test_a_tool_that_is_not_there_is_a_mismatch(tmp_path):
    model = exact_model('four')
    write_model(tmp_path / 'm.yaml', model)
    write_load_file(tmp_path / 'tool.yaml', block(2.5))
    pipeline = warm(build_pipeline(tmp_path / 'm.yaml', 'bayes',
                                   tool_path=tmp_path / 'tool.yaml'))
    last = feed(pipeline, messages(model, EMPTY, 5.0))[-1]
    assert last.mean[0] == pytest.approx(-2.5, abs=0.1) and last.determined[0]
    assert last.status == 'MODEL_MISMATCH'
    assert (f'the mass is {last.mean[0]:.2f} kg, and no load weighs less than nothing'
            in last.reason)
    with pytest.raises(TareError, match='MODEL_MISMATCH'):
        pipeline.tare(pipeline.last_stamp)


def test_what_was_tared_and_is_put_down_is_rightly_negative():
    model = exact_model('four')
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, block(1.5), 5.0))
    pipeline.tare(pipeline.last_stamp)
    later = feed(pipeline, [replace(m, stamp=m.stamp + 5.5)
                            for m in messages(model, EMPTY, 5.0, seed=1)])
    assert later[-1].mean[0] == pytest.approx(-1.5, abs=0.1)
    assert later[-1].status == 'DETERMINED'
