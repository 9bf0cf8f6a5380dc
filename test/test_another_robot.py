"""A model of another arm, or of another load, is refused with its reason; a wrong joint is not."""

from dataclasses import replace
import os
from pathlib import Path

from core_helpers import block
import numpy as np
import pytest
from residual_helpers import declared_model, recorded
from ros_helpers import ROOT

from hand_load_estimator.benchmark.real_robots import write_robot_file
from hand_load_estimator.benchmark.real_sets import SETS, stage
from hand_load_estimator.cli import main
from hand_load_estimator.errors import RecordingError
from hand_load_estimator.residual.doubts.another_robot import GAIN, refuse_another_robot

DATA = Path(os.environ.get('HAND_LOAD_DATA', ROOT.parent / 'shared' / 'data'))


def scaled(gains):
    """Return Evidence of the arm with torques times gains (n,) or one for all."""
    return [replace(run, torque=gains * run.torque) for run in recorded()]


def carrying(load, declared=None):
    """Return Evidence of the arm with a load in its hand, and another one declared or none."""
    robot, out = declared_model().robot, []
    for run in recorded():
        motion = run.motion
        held = np.array([robot.load_regressor(*row) @ load.to_products()
                         for row in zip(motion.q, motion.v, motion.a)])
        out.append(replace(run, torque=run.torque + held, load=declared or run.load))
    return out


def test_an_arm_of_another_size_is_another():
    """Other gains at most joints are none of torque constants: it says where and how much."""
    with pytest.raises(RecordingError) as refused:
        refuse_another_robot(declared_model(), scaled(np.array([1.0, 2.2, 0.62, 1.0])))
    said = str(refused.value)
    assert said.startswith('run 0: ') and '2.2 times at j1, 0.62 times at j2' in said
    assert f'{GAIN:g} times' in said and 'another robot' in said and 'hand_load check' in said


@pytest.mark.parametrize('gains', [
    (2.2, 1.0, 1.0, 1.0), (1.0, 2.2, 1.0, 1.0), (1.0, 1.0, 0.3, 1.0), 1.3, 0.8])
def test_neither_one_wrong_constant_nor_all_of_another_sensor_makes_another(gains):
    refuse_another_robot(declared_model(), scaled(np.array(gains)))


def test_a_load_that_hides_what_the_model_explains_is_told_as_one():
    """The arm looks like a heavier one; what to do about it is another thing."""
    with pytest.raises(RecordingError, match='looks loaded with about 5 kg, declared: none; .*'
                                             '--load'):
        refuse_another_robot(declared_model(), carrying(block(5.0)))
    with pytest.raises(RecordingError, match='looks loaded with about 5 kg, declared: 1 kg'):
        refuse_another_robot(declared_model(), carrying(block(4.0), block(1.0)))


def test_a_load_beside_which_the_model_explains_much_is_left_to_the_diagnosis():
    """Though the arm has twice the torques of the empty one."""
    refuse_another_robot(declared_model(), carrying(block(1.0)))


def dwelling(evidence, friction):
    """Return Evidence that stands for most of the time where it began, held by its friction."""
    motion, robot = evidence.motion, declared_model().robot
    stands = np.arange(len(motion.dt)) % 250 >= 50
    rows = np.where(stands, 0, np.arange(len(motion.dt)))
    q, v, a = (getattr(motion, name)[rows] for name in ('q', 'v', 'a'))
    v[stands], a[stands] = 0.0, 0.0
    gravity = robot.rigid_torque(motion.q[0], np.zeros(robot.n), np.zeros(robot.n))
    held = friction * np.random.default_rng(2).uniform(-1.0, 1.0, (6, robot.n))
    torque = np.where(stands[:, None], gravity + held[np.arange(len(q)) // 250], evidence.torque)
    return replace(evidence, motion=replace(motion, q=q, v=v, a=a), torque=torque)


def test_an_arm_that_mostly_stands_is_no_other_one():
    """Pauses between motions: what friction holds then, here much, is no fault of the model's."""
    model = declared_model()
    friction = [model.mean[where][0] for use, where in model.slices()
                if use.name == 'coulomb_friction']
    runs = [dwelling(run, 4.0 * np.array(friction)) for run in recorded()]
    standing = np.concatenate([np.abs(run.motion.v) < 0.01 for run in runs])
    assert standing.mean() > 0.7
    refuse_another_robot(model, runs)
    with pytest.raises(RecordingError, match='explains less than half'):
        refuse_another_robot(model, [replace(run, torque=-run.torque) for run in runs])


@pytest.mark.skipif(not (DATA / 'nist_ur5').is_dir() or not (DATA / 'ur10e').is_dir(),
                    reason=f'no recordings at {DATA}; set HAND_LOAD_DATA')
def test_the_model_of_a_ur5_is_refused_for_a_ur10e(tmp_path, capsys):
    """Same joint names, same kind of effort; a diagnosis would confirm torque scales of -0.96."""
    chosen = SETS['nist_ur5']
    robot = write_robot_file(chosen.robot, DATA, tmp_path)
    train, _ = stage(chosen, DATA / 'nist_ur5', tmp_path / 'runs')
    model = str(tmp_path / 'ur5.yaml')
    assert main(['identify', *map(str, train), '--robot', str(robot), '--effects',
                 ','.join(chosen.effects), '--out', model]) == 0
    runs = ('ident_20_02_05-20sec_8harm', 'ident_20_01_31-unload')
    status = main(['diagnose', *(str(DATA / 'ur10e' / run) for run in runs), '--model', model,
                   '--load', 'none', '--out', str(tmp_path / 'out')])
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert status == 2 and not (tmp_path / 'out').exists()
    assert runs[0] in said and 'times at shoulder_lift_joint' in said and 'another robot' in said
