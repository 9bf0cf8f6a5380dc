"""`hand_load simulate` writes what it says; motions by name stay inside all limits."""

from dataclasses import asdict

from hand_load_estimator.cli import main
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.motions.trajectory import Trajectory, write_trajectory_csv
from hand_load_estimator.plant import JointEvent, simulate_motion, TemperatureEvent
from hand_load_estimator.plant.difficulty import DEFAULT
from hand_load_estimator.recording import arrays, read_recording
from hand_load_estimator.residual.diagnose import errors_of
from hand_load_estimator.simulation.simulate_motions import MOTIONS, named_motion
from hand_load_estimator.stream.joint_stream import motion_of
from hand_load_estimator.torque.model_file import read_model
import numpy as np
from plant_helpers import chain, LOAD, ROBOTS, sweep, ur10e
import pytest
import yaml


def simulate(tmp_path, *arguments, out='bag'):
    """Return the exit status of `hand_load simulate` and the folder it was to write."""
    path = tmp_path / out
    return main(['simulate', '--robot', 'ur10e', '--out', str(path), *arguments]), path


def test_a_recording_is_written_with_its_load(tmp_path, capsys):
    write_load_file(tmp_path / 'load.yaml', LOAD)
    status, path = simulate(tmp_path, '--load', str(tmp_path / 'load.yaml'), '--duration', '3',
                            '--temperature', '35', '--seed', '3', '--rate', '250')
    assert status == 0 and 'times real time' in capsys.readouterr().out
    recording = read_recording(path)
    np.testing.assert_allclose(recording.load.to_message(), LOAD.to_message())
    time, position, _, effort = arrays(recording, ur10e().joints)
    assert len(time) == 876 and time[1] - time[0] == pytest.approx(0.004)
    assert np.ptp(position[:, 1]) > 0.1 and np.all(np.isfinite(effort))
    celsius = [s.value for s in recording.temperature_samples]
    assert len(celsius) == 6 * 36 and abs(np.mean(celsius) - 35.0) < 2.0


def test_no_load_is_written_as_none(tmp_path):
    _, path = simulate(tmp_path, '--duration', '1', '--motion', 'hold')
    assert read_recording(path).load.mass == 0.0


def test_a_load_of_unknown_place_is_refused(tmp_path, capsys):
    (tmp_path / 'load.yaml').write_text('mass: 1.0\n')
    status, path = simulate(tmp_path, '--load', str(tmp_path / 'load.yaml'))
    assert status == 2 and not path.exists()
    assert 'gives a mass without its com' in capsys.readouterr().err


def test_a_motion_file_is_followed_in_its_own_time(tmp_path):
    robot = ur10e()
    motion = named_motion('pick_place', robot, 3.0, seed=2)
    write_trajectory_csv(tmp_path / 'motion.csv', robot.joints, motion)
    status, path = simulate(tmp_path, '--motion', str(tmp_path / 'motion.csv'), '--speed', '0.5')
    time, position, _, _ = arrays(read_recording(path), robot.joints)
    assert status == 0 and time[-1] - time[0] == pytest.approx(6.5)
    np.testing.assert_allclose(position[-1], motion.position[-1], atol=0.01)


def test_a_motion_that_the_arm_refuses_leaves_nothing(tmp_path, capsys):
    robot = ur10e()
    motion = named_motion('pick_place', robot, 3.0, seed=2)
    beyond = Trajectory(motion.time, motion.position + 7.0, motion.velocity, motion.acceleration)
    write_trajectory_csv(tmp_path / 'motion.csv', robot.joints, beyond)
    status, path = simulate(tmp_path, '--motion', str(tmp_path / 'motion.csv'))
    assert status == 2 and 'limits of the URDF' in capsys.readouterr().err and not path.exists()


WRONG = {
    'unknown motion': (('--motion', 'dance'), 'pick_place'),
    'unknown load': (('--load', 'nowhere.yaml'), 'nowhere.yaml'),
    'unknown effects': (('--effects', 'nowhere.yaml'), 'nowhere.yaml'),
}


@pytest.mark.parametrize('case', WRONG)
def test_wrong_arguments_end_with_one_sentence_and_nothing_written(tmp_path, capsys, case):
    arguments, sentence = WRONG[case]
    status, path = simulate(tmp_path, *arguments)
    told = capsys.readouterr().err.strip()
    assert status == 2 and sentence in told and '\n' not in told and not path.exists()


def test_a_speed_above_one_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        simulate(tmp_path, '--speed', '1.5')
    assert ended.value.code == 2 and '--speed' in capsys.readouterr().err


def test_a_recording_is_never_written_over(tmp_path, capsys):
    (tmp_path / 'bag').mkdir()
    status, path = simulate(tmp_path)
    assert status == 2 and 'exists' in capsys.readouterr().err and not list(path.iterdir())


@pytest.mark.parametrize('name', MOTIONS)
@pytest.mark.parametrize('speed', [0.3, 1.0])
def test_motions_stay_inside_all_limits(name, speed):
    for robot in (ur10e(), chain('z', 'y', 'y', 'x')):
        motion = named_motion(name, robot, 12.0, speed, seed=4)
        q, v, a = motion.sample(np.linspace(0.0, 12.0, 3000))
        assert motion.start == 0.0 and motion.end == pytest.approx(12.0)
        assert np.all(q >= robot.limits.lower) and np.all(q <= robot.limits.upper)
        assert np.all(np.abs(v) <= speed * robot.limits.velocity * 1.001)
        assert np.all(np.abs(a) <= speed ** 2 * robot.limits.acceleration * 1.001)
        torque = [robot.rigid_torque(*row, robot.rated_load) for row in zip(q, v, a)]
        assert np.all(np.abs(torque) <= 1.02 * robot.limits.torque)
        for row in (v[0], v[-1], a[0], a[-1]):
            np.testing.assert_allclose(row, 0.0, atol=1e-6)
        assert np.ptp(q) > (0.3 if name != 'hold' else -1.0)


def test_excitation_really_moves_the_joints():
    motion = named_motion('excite', ur10e(), 20.0, 1.0, seed=0)
    _, v, _ = motion.sample(np.linspace(0.0, 20.0, 2000))
    assert np.all(np.max(np.abs(v), axis=0) > 0.25 * ur10e().limits.velocity)


def test_motions_follow_their_seed():
    one, same, other = (named_motion('pick_place', ur10e(), 10.0, seed=s) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.position, same.position)
    assert not np.allclose(one.position[0], other.position[0])


def test_events_come_in_order_and_a_load_changes_in_between():
    robot = ur10e()
    light, heavy = LoadParameters(), LoadParameters(10.0, [0.0, 0.0, 0.1])
    events = list(simulate_motion(robot, *sweep(robot, 2.0, 0.0), settle=0.2,
                                  load_changes=((1.0, heavy), (1.7, light))))
    stamps = [event.stamp for event in events]
    assert stamps == sorted(stamps) and stamps[-1] == pytest.approx(2.2)
    assert sum(isinstance(event, TemperatureEvent) for event in events) == 23
    effort = {round(e.stamp, 3): e.effort[1] for e in events if isinstance(e, JointEvent)}
    assert abs(effort[1.6] - effort[0.9]) > 50.0
    assert abs(effort[2.2] - effort[0.9]) < 30.0


def test_the_arm_is_that_of_the_shipped_model_unless_told_otherwise(tmp_path):
    model = read_model(find_shared('ur10e', 'models'))

    def error(*arguments, out):
        _, path = simulate(tmp_path, '--duration', '5', *arguments, out=out)
        recording = read_recording(path)
        motion, rejected = motion_of(model.robot, recording)
        evidence = prepare(model.robot, out, motion, recording.load, recording, rejected)
        return np.sqrt(np.nanmean(errors_of(model, [evidence]) ** 2, axis=0))
    own, other = error(out='own'), error('--seed', '2', out='other')
    assert (own < 2.0 * model.noise).all() and (other > 3.0 * own).sum() >= 3


def test_the_shown_figures_are_those_of_the_plant():
    shown = yaml.safe_load((ROBOTS.parent / 'plant.yaml').read_text())
    figures = {name: list(value) if isinstance(value, tuple) else value
               for name, value in asdict(DEFAULT).items()}
    assert shown == figures


def test_what_the_plant_refuses_leaves_no_recording(tmp_path, capsys):
    effects = tmp_path / 'effects.yaml'
    effects.write_text('effects:\n- {name: backlash, joints: [wrist_3_joint], strength: 1000}\n')
    out = tmp_path / 'recording'
    assert main(['simulate', '--robot', 'ur10e', '--out', str(out), '--duration', '2',
                 '--effects', str(effects)]) == 2
    assert 'backlash' in capsys.readouterr().err and not out.exists()


@pytest.mark.parametrize('effect', [
    '{name: viscous_friction, joints: [wrist_3_joint], parameters: {coefficient: 3000}}',
    '{name: gravity_spring, parameters: {stiffness: 1e30}}'])
def test_an_arm_that_runs_away_is_no_recording(tmp_path, capsys, effect):
    """It was written with infinite positions and told as a success."""
    (tmp_path / 'effects.yaml').write_text(f'effects: [{effect}]\n')
    status, path = simulate(tmp_path, '--duration', '2', '--rate', '100', '--effects',
                            str(tmp_path / 'effects.yaml'))
    said = capsys.readouterr().err.strip()
    assert status == 2 and not path.exists()
    assert 'runs away' in said and 'make effects weaker' in said and '\n' not in said
