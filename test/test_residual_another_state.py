"""Most joints differ, each by a cause of its own: rather another arm than so many defects."""

from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import declared_model, diagnosed, on, viscous

from hand_load_estimator.residual.diagnosis import CONFIRMED, Evidence, Finding, SUSPECTED
from hand_load_estimator.residual.doubts.another_state import FAR, of_another_state

JOINTS = declared_model().robot.joints
EVIDENCE = Evidence(100.0, 10.0, 30.0, 12, 900, 1.0)


def finding(name, *joints, recording='', parameters=()):
    return Finding(name, tuple(JOINTS[j] for j in joints), dict(parameters), np.zeros(4), EVIDENCE,
                   (), '', False, CONFIRMED, recording=recording)


def gains(*values, of='gain', name='torque_scale'):
    """Return a Finding of gains (value, std) of joints 0, 1, ..."""
    return finding(name, *range(len(values)), parameters={
        f'{of} ({joint})': (*value, '-') for joint, value in zip(JOINTS, values)})


def judged(findings, times):
    """Return Findings and sentences of an arm whose residual is so many times the noise (4,)."""
    model = declared_model()
    residual = np.ones((50, 1)) * np.asarray(times) * model.noise
    return of_another_state(tuple(findings), model, SimpleNamespace(
        residual=residual, moving=np.ones(residual.shape, bool)))


@pytest.mark.parametrize('findings, times, sure', [
    # Three of four joints have causes of their own, far beyond the noise.
    ([finding('viscous_friction', 0), finding('cable_drag', 1), finding('unknown', 2)], 4, False),
    # Not far; or fewer; or one cause of all joints.
    ([finding('viscous_friction', 0), finding('cable_drag', 1), finding('unknown', 2)], 2, True),
    ([finding('viscous_friction', 0), finding('cable_drag', 1)], 4, True),
    ([finding('time_delay', 0, 1, 2, 3), finding('cable_drag', 1)], 4, True),
    ([finding('base_tilt', 0, 1, 2, 3), finding('cable_drag', 1)], 4, True),
    # Gains that are not one and the same are each joint's own; they are where nothing tells.
    ([gains((0.1, 0.01), (-0.05, 0.01), (0.02, 0.01))], 4, False),
    ([gains((0.1, 0.01), (-0.05, 0.01), (0.02, 0.01), of='change_of_gain')], 4, False),
    ([gains((0.1, 0.01), (0.08, 0.01), (0.11, 0.01))], 4, True),
    ([gains((0.1, 0.1), (-0.05, 0.1), (0.02, 0.1))], 4, True),
    ([gains((0.1, 0.01), (0.1, 0.01), (0.1, 0.01), (0.03, 0.01))], 4, True),
    ([gains((0.1, 0.01), (0.1, 0.01)), finding('torque_scale', 2), finding('cable_drag', 3)], 4,
     True),
    ([gains((1e-3, 1e-4), (-1e-3, 1e-4), (3e-4, 1e-4), of='slope',
            name='torque_scale_temperature')], 4, False),
    ([finding('torque_scale', 0, 1, 2)], 4, True),
    ([finding('torque_scale', 0), finding('time_delay', 1), finding('cable_drag', 2)], 4, False),
    # What swings shakes all joints.
    ([finding('unknown', 0, 1, 2), finding('cable_drag', 1)], 4, True),
    ([finding('external_contact', 0, 1, 2, recording='run')], 4, True)])
def test_most_joints_with_causes_of_their_own_are_another_arm(findings, times, sure):
    found, told = judged(findings, np.full(4, times / 3.0 * FAR))
    assert [f.verdict for f in found] == [CONFIRMED if sure else SUSPECTED] * len(findings)
    assert bool(told) != sure
    if told:
        assert told[0].startswith('cannot tell defects from another arm, because 3 of 4 joints')


def test_what_happened_once_stays_confirmed():
    own = [finding('viscous_friction', j) for j in range(3)]
    found, _ = judged([*own, finding('external_contact', 1, recording='run')], np.full(4, 9.0))
    assert [f.verdict for f in found] == [SUSPECTED] * 3 + [CONFIRMED]


def test_friction_changed_at_three_of_four_joints_asks_for_a_new_model():
    diagnosis, _ = diagnosed(*(on(j, 8.0, viscous) for j in range(3)))
    assert {f.verdict for f in diagnosis.findings} == {SUSPECTED}
    assert 'identify this arm anew' in diagnosis.cannot_tell[0]
    assert diagnosis.another_state
