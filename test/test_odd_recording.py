"""A recording that does not agree with the others is told; effects that all show are not."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import cable, declared_model, diagnosed, on, recorded, ripple, viscous

from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.odd_recording import odd_recordings


@pytest.mark.parametrize('hidden', [(), (on(1, 5.0, viscous),),
                                    (on(2, 5.0, ripple), on(0, 2.0, cable))])
def test_recordings_of_one_arm_agree(hidden):
    diagnosis, better = diagnosed(*hidden)
    assert odd_recordings(better, recorded(*hidden)[:-1]) == []
    assert not any('same arm' in sentence for sentence in diagnosis.cannot_tell)


def test_a_recording_of_another_arm_is_told():
    runs = recorded()
    links = np.array([declared_model().robot.rigid_torque(*row) for row in
                      zip(runs[1].motion.q, runs[1].motion.v, runs[1].motion.a)])
    other = replace(runs[1], torque=runs[1].torque + 0.25 * links)
    diagnosis, _ = diagnose(declared_model(), [runs[0], other, runs[2]], runs[3:])
    (said,) = [text for text in diagnosis.cannot_tell if 'same arm' in text]
    assert said.startswith('cannot tell whether run 1 is of the same arm')


def test_one_recording_has_none_to_agree_with():
    assert odd_recordings(declared_model(), recorded(on(1, 9.0, viscous))[:1]) == []
