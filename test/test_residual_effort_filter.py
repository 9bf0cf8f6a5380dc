"""A filter of the effort is named beside the delay that it looks like."""

import numpy as np
from residual_helpers import a_little_late, declared_model, diagnosed

from hand_load_estimator.residual.diagnosis import CONFIRMED, SUSPECTED
from hand_load_estimator.residual.tracing.effort_filter import EFFORT_FILTER

LAG = 0.06


def lagging(run):
    """Effort behind a low-pass of first order, on all joints."""
    out = run.torque.copy()
    for k, dt in enumerate(np.diff(run.motion.stamp), start=1):
        out[k] = out[k - 1] + (1.0 - np.exp(-dt / LAG)) * (run.torque[k] - out[k - 1])
    return out - run.torque


def test_a_filtered_effort_is_no_delay_for_sure():
    diagnosis, _ = diagnosed(lagging)
    (finding,) = [f for f in diagnosis.findings if f.name == 'time_delay']
    assert finding.verdict == SUSPECTED
    assert EFFORT_FILTER in [other.name for other in finding.alternatives]
    assert 'slowly and quickly' in finding.advice
    assert any('a filter of the effort explains surely more' in text for text in diagnosis.remains)


def test_neither_is_a_delay_of_a_few_milliseconds():
    diagnosis, _ = diagnosed(a_little_late)
    (finding,) = [f for f in diagnosis.findings if f.verdict == CONFIRMED]
    assert finding.name == 'time_delay' and finding.joints == declared_model().robot.joints
    assert EFFORT_FILTER in [other.name for other in finding.alternatives]


def test_a_long_delay_is_told_from_a_filter():
    def much_later(run):
        time = run.motion.stamp
        return np.stack([np.interp(time - 0.15, time, torque) for torque in run.torque.T],
                        axis=1) - run.torque
    diagnosis, _ = diagnosed(much_later)
    (finding,) = [f for f in diagnosis.findings if f.name == 'time_delay']
    assert EFFORT_FILTER not in [other.name for other in finding.alternatives]
