"""Identification motions stay inside every limit, and their expected covariance is honest."""

import re

from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.robot_file import parse_robot
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.motions import excitation
from hand_load_estimator.motions.excitation import make_box, Search
from hand_load_estimator.motions.excitation_limits import check_centre, choose_centre, Clearance
from hand_load_estimator.motions.trajectory import read_trajectory_csv
from hand_load_estimator.robot import load_robot, Robot
import numpy as np
import pinocchio as pin
import pytest
import yaml

CENTRE = np.array([0.0, -1.6, 1.2, -1.2, -1.5, 0.0])
DURATION = 20.0


@pytest.fixture(scope='module')
def robot():
    return load_robot(find_shared('ur10e', 'robots'))


@pytest.fixture(autouse=True)
def short_search(monkeypatch):
    monkeypatch.setattr(excitation, 'DRAWS', 6)
    monkeypatch.setattr(excitation, 'REFINEMENTS', 6)


def searched(robot, reach=1.0, seed=0):
    search = Search(robot, make_box(robot, CENTRE, reach), DURATION,
                    0.005 * robot.limits.torque, seed)
    return search, search.run(lambda *_: None)


def samples(search, motion):
    trajectory = search.trajectory(motion)
    return trajectory.sample(np.arange(0.0, trajectory.end, 1.0 / search.information.rate))


def dense(trajectory):
    return trajectory.sample(np.arange(trajectory.start, trajectory.end, 0.002))


def test_all_limits_hold_between_the_knots(robot):
    search, motion = searched(robot)
    trajectory = search.trajectory(motion)
    q, v, a = dense(trajectory)
    limits = robot.limits
    assert np.all(np.abs(q - CENTRE) <= 1.0)
    assert np.all((q > limits.lower) & (q < limits.upper))
    assert np.all(np.abs(v) < limits.velocity) and np.all(np.abs(a) < limits.acceleration)
    data = robot.model.createData()
    tau = np.array([pin.rnea(robot.model, data, *s).copy() for s in zip(q[::5], v[::5], a[::5])])
    assert np.all(np.abs(tau) < limits.allowed_torque * limits.torque)
    assert trajectory.duration == pytest.approx(DURATION)


def test_rest_at_both_ends_and_consistent_derivatives(robot):
    search, motion = searched(robot)
    trajectory = search.trajectory(motion)
    for end in (0, -1):
        assert trajectory.position[end] == pytest.approx(CENTRE)
        assert np.abs(trajectory.velocity[end]).max() < 1e-9
        assert np.abs(trajectory.acceleration[end]).max() < 1e-9
    q, v, a = dense(trajectory)
    assert np.gradient(q, 0.002, axis=0)[1:-1] == pytest.approx(v[1:-1], abs=1e-3)
    assert np.gradient(v, 0.002, axis=0)[1:-1] == pytest.approx(a[1:-1], abs=2e-2)


def test_slow_and_fast_parts_with_reversals(robot):
    search, motion = searched(robot)
    q, v, _ = dense(search.trajectory(motion))
    slow = np.abs(v[:int(0.34 * len(v))]).max(axis=0)
    assert np.all(slow < 0.2 * robot.limits.velocity)
    assert np.abs(v).max() > 0.8 * robot.limits.velocity.max()
    reversals = np.sum(np.diff(np.sign(v), axis=0) != 0, axis=0)
    assert np.all(reversals >= 8)


def test_a_tight_torque_limit_is_kept(robot):
    weak = [330.0, 180.0, 80.0, 54.0, 54.0, 54.0]
    tight = Robot(parse_robot({**robot.file.content, 'max_torque': weak}, 'tight'))
    search, motion = searched(tight)
    q, v, a = dense(search.trajectory(motion))
    data = tight.model.createData()
    tau = np.array([pin.rnea(tight.model, data, *s).copy() for s in zip(q[::5], v[::5], a[::5])])
    assert np.all(np.abs(tau) < tight.limits.allowed_torque * np.array(weak))
    loose = searched(robot)[0].trajectory(searched(robot)[1])
    assert np.ptp(q[:, 1]) < np.ptp(loose.position[:, 1])


def test_a_slower_motion_is_the_same_path(tmp_path):
    def written(name, speed):
        out = tmp_path / name
        assert main(['excite', '--robot', 'ur10e', '--out', str(out), '--duration', '12',
                     '--centre=' + ','.join(map(str, CENTRE)), '--speed', str(speed)]) == 0
        return read_trajectory_csv(out.with_suffix('.csv'))[1]

    fast, slow = written('fast', 1), written('slow', 0.25)
    assert slow.duration == pytest.approx(4.0 * fast.duration)
    for moment in np.linspace(0.0, fast.duration, 50):
        q, v, a = fast.sample(moment)
        assert slow.sample(4.0 * moment)[0] == pytest.approx(q, abs=1e-5)
        assert slow.sample(4.0 * moment)[1] == pytest.approx(0.25 * v, abs=1e-4)


def test_search_improves_and_repeats(robot):
    costs = []
    search = Search(robot, make_box(robot, CENTRE, 1.0), DURATION, 0.005 * robot.limits.torque, 3)
    motion = search.run(lambda done, total, cost: costs.append(cost))
    assert len(costs) == 12 and costs[-1] < costs[0]
    assert all(later <= earlier for earlier, later in zip(costs, costs[1:]))
    again = searched(robot, seed=3)[1]
    assert np.array_equal(again.coefficients[1], motion.coefficients[1])
    other = searched(robot, seed=4)[1]
    assert not np.array_equal(other.coefficients[1], motion.coefficients[1])


def test_expected_std_is_what_identification_reaches(robot):
    """Fit noise alone with least squares: the torque it predicts is the expected error."""
    search, motion = searched(robot)
    information, random = search.information, np.random.default_rng(5)
    q, v, a = samples(search, motion)
    rows = information._rows(q, v, a).reshape(-1, 84)
    factor = np.linalg.pinv(rows @ information._base)
    expected, _ = information.torque_std(q, v, a)
    errors = []
    for _ in range(150):
        # Samples come at the information's rate; the design counts them as independent.
        parameters = information._base @ (factor @ random.standard_normal(len(rows)))
        errors.append(np.mean((information._test @ parameters)**2, axis=0))
    noise = 0.005 * robot.limits.torque
    assert np.sqrt(np.mean(errors, axis=0)) * noise == pytest.approx(expected, rel=0.1)


def test_longer_motion_and_less_noise_are_expected_to_be_better(robot):
    noise = 0.005 * robot.limits.torque
    stds = []
    for duration, scale in ((20.0, 1.0), (60.0, 1.0), (20.0, 0.5)):
        search = Search(robot, make_box(robot, CENTRE, 1.0), duration, scale * noise, 0)
        stds.append(search.information.torque_std(*samples(
            search, search.run(lambda *_: None)))[0].mean())
    assert stds[1] < stds[0]
    assert stds[2] == pytest.approx(0.5 * stds[0], rel=1e-3)


def test_default_centre_keeps_clear_of_the_base(robot):
    random = np.random.default_rng(0)
    centre = choose_centre(robot, 1.0, random)
    clearance = Clearance(robot)
    around = centre + random.uniform(-1.0, 1.0, (50, 6))
    assert clearance.of(around) > clearance.of(around - centre)
    check_centre(robot, centre)


def test_clearance_sees_the_mounting_plane(robot):
    # Stretched out and 0.3 rad down, the hand of a UR10e is below its base.
    assert Clearance(robot).of([np.array([0.0, 0.4, 0.0, 0.0, 0.0, 0.0])]) < 0.0
    assert Clearance(robot).of([np.array([0.0, -1.57, 0.0, 0.0, 0.0, 0.0])]) > 0.15


def test_unusable_centre_is_refused(robot):
    with pytest.raises(ConfigurationError, match='elbow_joint'):
        check_centre(robot, [0.0, 0.0, 9.0, 0.0, 0.0, 0.0])
    heavy = Robot(parse_robot({**robot.file.content, 'max_torque': [20.0] * 6}, 'weak'))
    with pytest.raises(ConfigurationError, match='to hold'):
        check_centre(heavy, np.zeros(6))


def test_without_a_given_centre_the_joint_is_told(robot, tmp_path, capsys):
    """A gripper's finger with 30 mm of travel, and drives too weak for the pose."""
    (tmp_path / 'finger.urdf').write_text(re.sub(
        r'(<joint name="wrist_3_joint".*?)lower="[^"]*" upper="[^"]*"',
        r'\1lower="0" upper="0.03"', robot.file.urdf, flags=re.S))
    (tmp_path / 'arm.urdf').write_text(robot.file.urdf)
    content = yaml.safe_load(find_shared('ur10e', 'robots').read_text())
    for changes, words in (({'urdf': 'finger.urdf'}, 'wrist_3_joint has no room to move'),
                           ({'urdf': 'arm.urdf', 'max_torque': [20.0] * 6},
                            'of its allowed torque to hold')):
        path = tmp_path / 'arm.yaml'
        path.write_text(yaml.safe_dump({**content, **changes}))
        assert main(['excite', '--robot', str(path), '--out', str(tmp_path / 'm')]) == 2
        said = capsys.readouterr().err
        assert f'{path}: ' in said and words in said and '--centre:' not in said
        assert said.count('\n') == 1


def test_command_writes_both_forms_of_one_motion(robot, tmp_path, capsys):
    out = tmp_path / 'motion.csv'
    arguments = ['excite', '--robot', 'ur10e', '--out', str(out), '--duration', '12',
                 '--centre=' + ','.join(map(str, CENTRE))]
    assert main(arguments) == 0
    assert 'std of coulomb friction' in capsys.readouterr().out
    joints, trajectory = read_trajectory_csv(out)
    message = yaml.safe_load((tmp_path / 'motion.yaml').read_text())
    assert tuple(message['joint_names']) == joints == robot.joints
    for point in message['points']:
        stamp = point['time_from_start']
        q, v, a = trajectory.sample(stamp['sec'] + 1e-9 * stamp['nanosec'])
        assert point['positions'] == pytest.approx(q, abs=1e-5)
        assert point['velocities'] == pytest.approx(v, abs=1e-4)
        assert all(type(x) is float for x in point['positions'] + point['accelerations'])
    assert message['points'][-1]['velocities'] == pytest.approx(np.zeros(6), abs=1e-6)
    assert main(arguments) == 2
    assert 'exists already' in capsys.readouterr().err


@pytest.mark.parametrize('option, value', [
    ('--speed', '0'), ('--duration', '1'), ('--centre', '1,2'), ('--noise', '0,1,1,1,1,1'),
    ('--reach', '9'), ('--robot', 'no_robot'), ('--out', '/no/such/folder/x')])
def test_wrong_arguments_are_refused_in_one_line(tmp_path, capsys, option, value):
    arguments = {'--robot': 'ur10e', '--out': str(tmp_path / 'm'), option: value}
    assert main(['excite', *(part for pair in arguments.items() for part in pair)]) == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1
    assert not list(tmp_path.iterdir())
