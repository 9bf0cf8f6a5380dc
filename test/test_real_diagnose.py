"""`hand_load diagnose` on recordings of a real UR10e that are no clean motion without load."""

import json
import os
from pathlib import Path
import warnings

import pytest
from ros_helpers import ROOT

from hand_load_estimator.benchmark.real_robots import ARMS, write_robot_file
from hand_load_estimator.benchmark.real_sets import SETS, stage
from hand_load_estimator.cli import main

SETS_FOLDER = Path(os.environ.get('HAND_LOAD_DATA', ROOT.parent / 'shared' / 'data'))
DATA = SETS_FOLDER / 'ur10e'
UNLOADED = ('ident_20_02_05-20sec_8harm', 'ident_20_02_06-20sec_10harm', 'ident_20_01_31-unload')
PUSHES = 'push_20_01_22-push_pose_{}'

pytestmark = pytest.mark.skipif(
    not (DATA / PUSHES.format(1)).is_dir(),
    reason=f'no recordings at {DATA}; set HAND_LOAD_DATA to the folder that holds ur10e/')


@pytest.fixture(scope='module')
def model(tmp_path_factory):
    """Return the path of a model of three unloaded runs."""
    path = tmp_path_factory.mktemp('real') / 'model.yaml'
    chosen = SETS['ur10e']
    assert main(['identify', *(str(DATA / run) for run in UNLOADED), '--robot', chosen.robot,
                 '--effects', ','.join(chosen.effects), '--load', 'none',
                 '--out', str(path)]) == 0
    return path


def diagnosed(model, tmp_path, *runs):
    """Return (exit status, report or None) of runs that are said to carry nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter('error', RuntimeWarning)
        status = main(['diagnose', *(str(DATA / run) for run in runs), '--model', str(model),
                       '--load', 'none', '--out', str(tmp_path / 'out')])
    report = tmp_path / 'out' / 'report.json'
    return status, json.loads(report.read_text()) if report.exists() else None


# Times [s] by eye in the recorded currents; of the pushes with three strong joints, the hand's.
@pytest.mark.parametrize('pose, times, hand', [
    (1, (4.7, 8.5, 12.0), (0,)), (2, (0.6, 2.5, 5.0, 8.2, 11.4, 14.3), (1, 4))])
def test_the_pushes_on_a_held_arm_are_found(model, tmp_path, capsys, pose, times, hand):
    """What friction can hold hides the lightest; nothing else is claimed of an arm at rest."""
    status, report = diagnosed(model, tmp_path, PUSHES.format(pose))
    assert status == 0 and 'not known Nm' not in capsys.readouterr().out
    effects = report['effects']
    assert {(e['name'], e['verdict']) for e in effects} == {('external_contact', 'confirmed')}
    starts = [e['parameters']['start']['mean'] for e in effects]
    assert starts == pytest.approx(times, abs=0.2)
    assert tuple(k for k, e in enumerate(effects) if 'force_x' in e['parameters']) == hand
    for k in hand:
        newtons = sum(effects[k]['parameters'][f'force_{axis}']['mean'] ** 2 for axis in 'xyz')
        assert 40.0 < newtons ** 0.5 < 120.0
    assert report['before']['torque_rmse'] == [None] * 6


def test_a_load_that_was_not_declared_is_said(model, tmp_path, capsys):
    status, report = diagnosed(model, tmp_path, 'ident_20_01_13-load_2600')
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert status == 2 and report is None
    assert 'ident_20_01_13-load_2600 looks loaded with about 2.' in said
    assert 'declared: none' in said and '--load' in said and 'hand_load excite' not in said


def test_a_joint_that_is_shaken_has_no_error(model, tmp_path):
    """The shoulder moves; in the last quarter the elbow shakes by 2 mrad."""
    status, report = diagnosed(model, tmp_path, 'jointwise_20_01_22-joint_2')
    known = [error is not None for error in report['before']['torque_rmse']]
    assert status == 0 and known == [False, True, False, False, False, False]
    assert any('elbow_joint' in s and 'never moves' in s for s in report['cannot_tell'])


@pytest.mark.skipif(not (SETS_FOLDER / 'nist_ur5').is_dir(), reason=f'no UR5 at {SETS_FOLDER}')
def test_no_effect_of_temperature_is_named_where_nothing_warms(tmp_path):
    """The UR5's joints warm by less than a degree in the run."""
    chosen = SETS['nist_ur5']
    train, test = stage(chosen, SETS_FOLDER / 'nist_ur5', tmp_path / 'runs')
    robot = write_robot_file('nist_ur5', SETS_FOLDER, tmp_path) if chosen.robot in ARMS \
        else chosen.robot
    base, out = tmp_path / 'base.yaml', tmp_path / 'out'
    assert main(['identify', *map(str, train), '--robot', str(robot), '--effects',
                 ','.join(chosen.effects), '--out', str(base)]) == 0
    assert main(['diagnose', *map(str, train), '--model', str(base), '--out', str(out),
                 '--test', *map(str, test)]) == 0
    report = json.loads((out / 'report.json').read_text())
    names = {effect['name'] for effect in report['effects']}
    assert not [name for name in names if 'temperature' in name]
    assert any('temperature' in sentence for sentence in report['cannot_tell'])
    sure = {effect['name'] for effect in report['effects'] if effect['verdict'] == 'confirmed'}
    assert sure <= {'torque_ripple'}
