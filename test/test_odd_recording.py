"""A recording that does not agree with the others is told; effects that all show are not."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import (cable, declared_model, diagnosed, on, recorded, ripple, viscous,
                              warming)

from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.doubts.odd_recording import odd_recordings


@pytest.mark.parametrize('hidden', [(), (on(2, 5.0, ripple), on(0, 2.0, cable))])
def test_recordings_of_one_arm_agree(hidden):
    diagnosis, _ = diagnosed(*hidden)
    assert not any('same arm' in sentence for sentence in diagnosis.cannot_tell)


def another_arm(run):
    """Return a run of an arm of the same kind: other gears, other friction."""
    gains = np.array([1.2, 0.85, 1.15, 0.8])
    rub = np.array([2.0, -1.0, 1.0, -0.4]) * np.tanh(run.motion.v / 0.1)
    return replace(run, torque=run.torque * gains + rub)


@pytest.mark.parametrize('others', [(0, 2), (0,)])
def test_a_recording_of_another_arm_is_told(others):
    runs = recorded(celsius=(25.0, 25.0))
    mixed = [*(runs[k] for k in others), another_arm(runs[1])]
    diagnosis, _ = diagnose(declared_model(), mixed, runs[3:])
    (said,) = [text for text in diagnosis.cannot_tell if 'same arm' in text]
    assert said.startswith('cannot tell whether run 1 is of the same arm')


def test_a_recording_kept_for_the_test_may_be_of_another_arm():
    runs = recorded(celsius=(25.0, 25.0))
    diagnosis, _ = diagnose(declared_model(), runs[:3], [another_arm(runs[3])])
    (said,) = [text for text in diagnosis.cannot_tell if 'same arm' in text]
    assert said.startswith('cannot tell whether run 3 is of the same arm')


def test_an_effect_of_the_whole_arm_that_warm_runs_show_most_is_none():
    hidden = [on(j, 6.0, warming) for j in range(4)]
    diagnosis, _ = diagnosed(*hidden, celsius=(25.5, 35.0))
    assert not any('same arm' in sentence for sentence in diagnosis.cannot_tell)


def test_recordings_are_known_by_their_content_not_their_folders_name():
    runs = [replace(run, name='bag', messages=np.array([k], np.uint64))
            for k, run in enumerate(recorded()[:3])]
    left = [0.1, 9.0, 0.1]
    (said,) = odd_recordings(declared_model(), runs,
                             lambda parts: np.full(4, left[int(parts[0].messages[0])]), None)
    assert 'is off by 9 Nm there and by 0.1 Nm' in said


def test_one_recording_has_none_to_agree_with():
    assert odd_recordings(
        declared_model(), recorded(on(1, 9.0, viscous))[:1], lambda parts: np.ones(4), None) == []
