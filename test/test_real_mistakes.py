"""Mistakes put into recordings of real arms, joint by joint: which of them are refused."""

from dataclasses import replace
from functools import lru_cache
import os
from pathlib import Path

import numpy as np
import pytest
from ros_helpers import ROOT

from hand_load_estimator.benchmark.real_robots import ARMS, write_robot_file
from hand_load_estimator.benchmark.real_sets import SETS, stage
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.recording import read_recording
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import SUSPECTED, UNKNOWN
from hand_load_estimator.residual.doubts.wrong_joint import wrong_joint
from hand_load_estimator.robot import load_robot
from hand_load_estimator.stream.joint_stream import motion_of

DATA = Path(os.environ.get('HAND_LOAD_DATA', ROOT.parent / 'shared' / 'data'))
ANGLES, EFFORT = ('q', 'v', 'a'), ('effort',)


@lru_cache(None)
def arm(name, folder):
    """Return the TorqueModel of a set, as every diagnosis starts, and Evidence of its tests."""
    chosen, folder = SETS[name], Path(folder)
    train, test = stage(chosen, DATA / name, folder / 'runs')
    path = (write_robot_file(name, DATA, folder) if chosen.robot in ARMS
            else find_shared(chosen.robot, 'robots'))
    robot = load_robot(path)
    read = [[evidence_of(robot, read_recording(run)) for run in runs] for runs in (train, test)]
    return identify(robot, read[0], chosen.effects), read[1]


def evidence_of(robot, recording):
    motion, rejected = motion_of(robot, recording)
    return prepare(robot, recording.path.name, motion, recording.load, recording, rejected)


def mistaken(run, model, names, change):
    """Return the Evidence with some arrays of its Motion changed, torques with the efforts."""
    motion = replace(run.motion, **{name: change(getattr(run.motion, name)) for name in names})
    unit = model.robot.effort.torque_constants
    torque = change(run.torque / unit) * unit if 'effort' in names else run.torque
    return replace(run, motion=motion, torque=torque)


def mistakes(n):
    """Yield (name, arrays, change) of every mistake with one joint or two neighbours."""
    for j in range(n):
        sign = np.where(np.arange(n) == j, -1.0, 1.0)
        yield f'angle of {j}', ANGLES, lambda values, sign=sign: values * sign
        yield f'sign of {j}', EFFORT, lambda values, sign=sign: values * sign
        yield f'no effort of {j}', EFFORT, lambda values, sign=sign: values * (sign > 0.0)
    for j in range(n - 1):
        order = np.arange(n)
        order[[j, j + 1]] = j + 1, j
        yield f'efforts of {j}', EFFORT, lambda values, order=order: values[:, order]
        yield f'all of {j}', ANGLES + EFFORT, lambda values, order=order: values[:, order]


@pytest.mark.parametrize('name', ['ur10e', 'panda'])
def test_mistakes_with_real_arms_are_refused(name, tmp_path_factory):
    if not (DATA / name).is_dir():
        pytest.skip(f'no recordings at {DATA}; set HAND_LOAD_DATA')
    model, runs = arm(name, str(tmp_path_factory.mktemp(name)))
    assert all(wrong_joint(model, [run]) == '' for run in runs)
    found = {label: wrong_joint(model, [mistaken(runs[0], model, names, change)])
             for label, names, change in mistakes(model.robot.n)}
    assert [label for label, said in found.items() if not said] == []


def test_wrists_nearly_alike_are_refused_exchanged_but_for_one_recording(tmp_path_factory):
    """And of that one nothing is named: what it says is that a joint keeps its structure."""
    if not (DATA / 'ur10e').is_dir():
        pytest.skip(f'no recordings at {DATA}; set HAND_LOAD_DATA')
    model, runs = arm('ur10e', str(tmp_path_factory.mktemp('ur10e')))
    exchanged = {label: how for label, *how in mistakes(model.robot.n)}['all of 4']
    passed = [run for run in (mistaken(run, model, *exchanged) for run in runs)
              if not wrong_joint(model, [run])]
    assert len(runs) == 5 and [run.name for run in passed] == ['valid_20_01_17-ptp_10_points']
    diagnosis, _ = diagnose(model, passed, [])
    assert {(f.name, f.verdict) for f in diagnosis.findings} == {(UNKNOWN, SUSPECTED)}
    assert any(model.robot.joints[5] in f.joints for f in diagnosis.findings)
