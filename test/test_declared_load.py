"""A load that is on the hand and that nobody declared is told before a model is made of it."""

from dataclasses import replace
import os
from pathlib import Path

import pytest

from hand_load_estimator.checks.declared_load import another_load
from hand_load_estimator.checks.recording_check import check_recording
from hand_load_estimator.cli import main
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.recording import read_recording
from hand_load_estimator.robot import load_robot

DATA = Path(os.environ.get('HAND_LOAD_DATA', Path(__file__).parents[2] / 'shared' / 'data'))
LOAD = LoadParameters(2.5, [0.0, 0.02, 0.08])
NONE = LoadParameters()


@pytest.fixture(scope='module')
def robot():
    return load_robot(find_shared('ur10e', 'robots'))


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with two recordings of one simulated arm, whose links are not nominal."""
    out = tmp_path_factory.mktemp('declared')
    write_load_file(out / 'load.yaml', LOAD)
    for run, load in (('empty', 'none'), ('loaded', str(out / 'load.yaml'))):
        assert main(['simulate', '--robot', 'ur10e', '--out', str(out / run), '--load', load,
                     '--motion', 'excite', '--duration', '15', '--rate', '100']) == 0
    return out


def test_only_a_contradiction_is_told(robot, folder):
    empty, loaded = (read_recording(folder / run) for run in ('empty', 'loaded'))
    assert another_load(robot, empty, NONE) == another_load(robot, loaded, LOAD) == ''
    assert 'stated: 0 kg' in another_load(robot, loaded, NONE)
    assert 'stated: 2.5 kg' in another_load(robot, empty, LOAD)


def test_a_recording_that_cannot_tell_is_passed_over(robot, folder):
    loaded = read_recording(folder / 'loaded')
    assert another_load(robot, replace(loaded, samples=loaded.samples[:100]), NONE) == ''


def test_less_than_no_load_is_not_one_that_was_forgotten(folder):
    """As on a measured Staubli TX40 without load, whose nominal links are too heavy."""
    heavy = load_robot(find_shared('ur10e', 'robots'))
    heavy.model.inertias[heavy.n].mass += 3.0
    empty = read_recording(folder / 'empty')
    assert another_load(heavy, empty, NONE) == ''
    assert 'link masses' in [f.item for f in check_recording(empty, heavy).findings]


def test_identify_warns_of_the_recording(folder, capsys):
    for run, warned in (('empty', False), ('loaded', True)):
        out = folder / f'{run}.yaml'
        assert main(['identify', str(folder / run), '--robot', 'ur10e', '--load', 'none', '--out',
                     str(out), '--effects', 'coulomb_friction,viscous_friction']) == 0
        said = capsys.readouterr().err
        assert (f'WARNING: {run}: the effort looks like' in said) == warned


@pytest.mark.skipif(not (DATA / 'ur10e').is_dir(), reason=f'no recordings at {DATA}')
@pytest.mark.parametrize('run, mass', [('ident_20_01_13-load_2600', 2.6),
                                       ('ident_20_02_06-20sec_5harm', 0.0),
                                       ('jointwise_20_01_22-joint_6', 0.0)])
def test_measured_arms_too(run, mass):
    robot = load_robot(find_shared('ur10e_current', 'robots'))
    recording = read_recording(DATA / 'ur10e' / run)
    assert bool(another_load(robot, recording, NONE)) == (mass > 0.0)
    stated = LoadParameters(mass, robot.rated_load.com)
    assert another_load(robot, recording, stated) == ''
