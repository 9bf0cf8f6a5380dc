"""Where friction does not follow the temperatures recorded, no effect of them is confirmed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import declared_model

from hand_load_estimator.residual.diagnosis import CONFIRMED, Evidence, Finding, SUSPECTED
from hand_load_estimator.residual.doubts.temperatures_not_felt import not_felt

MODEL = declared_model()
WARM, OTHER = (Finding(name, (MODEL.robot.joints[3],), {}, np.eye(4)[3],
                       Evidence(100.0, 10.0, 30.0, 12, 900, 1.0), (), '', False, CONFIRMED)
               for name in ('torque_scale_temperature', 'cable_drag'))


def following(shares):
    """Return the model with so much left at each joint (4,) of what its temperature changes."""
    mean = MODEL.mean.copy()
    for use, where in MODEL.slices():
        if use.name.startswith('temperature_dependent'):
            mean[where] *= shares[use.joint]
    return SimpleNamespace(robot=MODEL.robot, mean=mean, slices=MODEL.slices)


@pytest.mark.parametrize('shares, warmed, doubted', [
    ((1.0, 0.1, 0.1, 1.0), (0, 1, 2, 3), True), ((1.0, 0.1, 0.5, 1.0), (0, 1, 2, 3), False),
    ((1.0, -0.1, 0.0, 1.2), (0, 1, 2, 3), True), ((1.0, 0.1, 0.1, 1.0), (0, 1, 3), False)])
def test_where_most_joints_do_not_feel_them_they_are_doubted(shares, warmed, doubted):
    found, told = not_felt((WARM, OTHER), MODEL, following(shares), warmed)
    assert [f.verdict for f in found] == [SUSPECTED if doubted else CONFIRMED, CONFIRMED]
    assert [text.startswith('j3: torque_scale_temperature is only suspected, because friction of '
                            'j1, j2 ') for text in told] == [True] * doubted


def test_what_is_suspected_already_stays_so():
    before = (replace(WARM, verdict=SUSPECTED), OTHER)
    assert not_felt(before, MODEL, following([0.0] * 4), (0, 1, 2, 3)) == (before, ())
