"""Recordings without temperatures: friction as of another one is no effect of unknown kind."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import declared_model, on, recorded

from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED, Evidence, Finding, SUSPECTED, UNKNOWN
from hand_load_estimator.residual.doubts.limits import warmed_joints
from hand_load_estimator.residual.doubts.odd_recording import odd_recordings
from hand_load_estimator.residual.doubts.unknown_temperature import (
    lacks_temperature, without_unknown_temperature)

JOINTS = declared_model().robot.joints


def without(evidence, joints=slice(None)):
    """Return Evidence without temperatures of some joints."""
    temperature = evidence.motion.temperature.copy()
    temperature[:, joints] = np.nan
    return replace(evidence, motion=replace(evidence.motion, temperature=temperature))


def unknown(joints, verdict=SUSPECTED):
    return Finding(UNKNOWN, joints, {}, np.zeros(4), Evidence(np.nan, np.nan, 30.0, 12, 900, 1.0),
                   (), '', False, verdict, variables=('time',))


def test_cold_and_warm_friction_without_temperatures_is_nothing_unknown():
    """The clean arm at 5 and 45 degC; with temperatures nothing is left, without, friction."""
    model, runs = declared_model(), recorded(celsius=(5.0, 45.0))
    known, _ = diagnose(model, runs)
    assert not known.findings and not any('temperature' in told for told in known.cannot_tell)
    blind, _ = diagnose(model, [without(run) for run in runs])
    assert not blind.findings
    assert any('without temperatures what is left there' in told for told in blind.cannot_tell)
    assert (blind.stated > known.stated).any()


def test_what_is_more_than_friction_of_another_temperature_stays_unknown():
    joint = 2

    def beat(run):
        t = run.motion.stamp[:, None] * np.ones(4)
        return np.sign(np.sin(9.0 * t) * np.sin(2.3 * t))

    runs = [without(run) for run in recorded(on(joint, 40.0, beat), celsius=(5.0, 45.0))]
    found, _ = diagnose(declared_model(), runs)
    assert UNKNOWN in {f.name for f in found.findings if JOINTS[joint] in f.joints}


def test_only_what_is_suspected_and_within_is_taken_out():
    robot, rows = declared_model().robot, 100
    residual = SimpleNamespace(moving=np.ones((rows, 4), bool), dt=np.full(rows, 0.02))
    rest = np.ones((rows, 4)) * [9.0, 2.0, 3.0, 4.0]
    findings = (unknown(JOINTS[:3]), unknown(JOINTS[2:3]), unknown(JOINTS[3:], CONFIRMED))
    within = np.array([True, False, False, True])
    kept, (told,) = without_unknown_temperature(findings, robot, within, residual, rest)
    assert [f.joints for f in kept] == [JOINTS[1:3], JOINTS[2:3], JOINTS[3:]]
    assert f'at {JOINTS[0]} because' in told
    # What is told and drawn is of the joints that stay.
    assert kept[0].evidence.rms == 3.0 and kept[0].pictures[0].joint == JOINTS[2]
    assert kept[1:] == findings[1:]
    kept, _ = without_unknown_temperature(findings, robot, np.ones(4, bool), residual, rest)
    assert kept == findings[2:]
    same, told = without_unknown_temperature(findings, robot, np.zeros(4, bool), residual, rest)
    assert same == findings and not told


def test_a_joint_lacks_temperatures_where_its_friction_depends_on_them():
    run = recorded()[0]
    assert not lacks_temperature(declared_model(), run).any()
    assert lacks_temperature(declared_model(), without(run, 1)).tolist() == [
        False, True, False, False]
    plain = declared_model(names=('coulomb_friction', 'viscous_friction'))
    assert not lacks_temperature(plain, without(run)).any()


def test_one_recording_without_temperatures_is_told_and_not_odd():
    model, runs = declared_model(), recorded(celsius=(5.0, 45.0))
    runs[1] = without(runs[1])
    _, told = warmed_joints(model, runs)
    assert told == ['cannot tell what of run 1 is of temperature because none was recorded there; '
                    'the other recordings say what depends on it']

    def odd(left, expected):
        return odd_recordings(model, runs, lambda parts: np.full(
            4, left if parts[0] is runs[1] else 1.0), lambda parts: np.full(4, expected))

    assert odd(20.0, 7.0) == []
    # More than friction as of any temperature is another arm's all the same.
    (said,) = odd(20.0, 6.0)
    assert 'whether run 1 is of the same arm' in said


@pytest.mark.parametrize('celsius', [(40.0, 40.0), (5.0, 45.0)])
def test_a_first_reading_that_comes_late_leaves_no_recording_without_temperatures(celsius):
    """A topic of 1 Hz begins after the joint states; what was not known counts as 0."""
    runs = recorded(on(1, 5.0, lambda run: run.x.z), celsius=celsius)
    late = []
    for run in runs:
        temperature = run.motion.temperature.copy()
        temperature[:25] = np.nan
        late.append(replace(run, motion=replace(run.motion, temperature=temperature)))
    assert not any(lacks_temperature(declared_model(), run).any() for run in late)
    for given in (runs, late):
        (found,) = diagnose(declared_model(), given)[0].findings
        others = [other.name for other in found.alternatives]
        assert found.name == 'coulomb_friction'
        assert ('temperature_dependent_coulomb_friction' in others) == (celsius[0] == celsius[1])
        assert ('at three temperatures' in found.advice) == (celsius[0] == celsius[1])
