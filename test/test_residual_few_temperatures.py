"""Effects of temperature that two recordings differ by, as by anything else between them."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import declared_model, recorded

from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.residual.diagnosis import CONFIRMED, Evidence, Finding, SUSPECTED
from hand_load_estimator.residual.doubts.few_temperatures import between_two_temperatures

JOINTS = declared_model().robot.joints
NAME = 'temperature_dependent_viscous_friction'


def finding(name):
    return Finding(name, JOINTS[1:2], {}, np.zeros(4), Evidence(100.0, 10.0, 30.0, 12, 900, 1.0),
                   (), '', False, CONFIRMED)


def warming(evidence, kelvin, unknown=0):
    """Return Evidence whose joints warm by so much within it, known after some rows."""
    temperature = evidence.motion.temperature + np.linspace(
        0.0, kelvin, len(evidence.torque))[:, None]
    temperature[:unknown] = np.nan
    return replace(evidence, motion=replace(evidence.motion, temperature=temperature))


@pytest.mark.parametrize('name, runs, kelvin, sure', [
    (NAME, 2, 0.0, False), (NAME, 3, 0.0, True), (NAME, 2, 5.0, True), (NAME, 1, 5.0, True),
    ('viscous_friction', 2, 0.0, True)])
def test_a_third_temperature_or_a_joint_that_warms_is_needed(name, runs, kelvin, sure):
    evidence = [warming(e, kelvin) for e in recorded()[:runs]]
    assert len({e.mark for e in evidence}) == runs
    (found,), told = between_two_temperatures((finding(name),), JOINTS, evidence)
    assert found.verdict == (CONFIRMED if sure else SUSPECTED)
    assert [text.split(':')[0] for text in told] == ([] if sure else [JOINTS[1]])


def test_a_sensor_that_is_heard_late_or_not_at_all_hides_no_warming():
    first, second = recorded()[:2]
    for evidence in ([warming(first, 5.0, unknown=100), second],
                     [warming(first, 5.0), warming(second, 0.0, unknown=len(second.torque))]):
        (found,), told = between_two_temperatures((finding(NAME),), JOINTS, evidence)
        assert found.verdict == CONFIRMED and not told


def test_parts_of_one_recording_are_one(monkeypatch):
    first, second, third = recorded()[:3]
    parts = [replace(e, name=name) for e, name in ((first, 'a'), (second, 'b'), (third, 'b'))]
    assert parts[1].mark == parts[2].mark == RecordingMark('b', parts[1].mark.content)
    (found,), _ = between_two_temperatures((finding(NAME),), JOINTS, parts)
    assert found.verdict == CONFIRMED  # run b is 15 and 35 degC: it warms
