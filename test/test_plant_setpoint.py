"""Trajectories are taken, interpolated and refused as ros2_control's controller does."""

from hand_load_estimator.motions.trajectory import Trajectory
from hand_load_estimator.plant import Plant, TrajectoryError
from hand_load_estimator.plant.setpoint import Setpoint
from hand_load_estimator.robot import robot_from_content
import numpy as np
from plant_helpers import chain, ur10e
import pytest

JOINTS = ('a', 'b')
START = np.array([0.1, -0.2])
STOPS = np.array([[-2.97, -np.inf], [2.97, np.inf]])
GOAL = np.array([0.5, 0.4])


def setpoint():
    return Setpoint(JOINTS, START, STOPS)


@pytest.mark.parametrize('order', [1, 3, 5])
def test_it_passes_through_the_points(order):
    point = setpoint()
    rows = [[[0.3, 0.0], GOAL], [[0.2, -0.1], [0.0, 0.0]], [[0.5, 0.0], [0.0, 0.0]]]
    point.take(2.0, JOINTS, [1.0, 2.0], *rows[:(order + 1) // 2])
    state = point.advance(3.0 - 1e-6)
    np.testing.assert_allclose(state[0], rows[0][0], atol=1e-5)
    if order > 1:
        np.testing.assert_allclose(state[1], rows[1][0], atol=1e-4)
    if order > 3:
        np.testing.assert_allclose(state[2], rows[2][0], atol=1e-3)
    np.testing.assert_allclose(point.advance(4.5), [GOAL, [0.0, 0.0], [0.0, 0.0]])
    assert not point.moving


def test_quintics_are_those_of_the_trajectory_module():
    rng = np.random.default_rng(0)
    time = np.array([0.0, 0.4, 1.0, 1.7])
    q, v, a = rng.uniform(-1.0, 1.0, (3, 4, 2))
    v[-1] = a[-1] = 0.0
    expected, point = Trajectory(time, q, v, a), setpoint()
    point.take(0.0, JOINTS, time, q, v, a)
    for t in np.linspace(0.0, 1.69, 40):
        np.testing.assert_allclose(point.advance(t), expected.sample(t), atol=1e-9)


def test_joints_in_another_order_are_found_by_name():
    point = setpoint()
    point.take(0.0, ('b', 'a'), [1.0], [GOAL[::-1]])
    np.testing.assert_allclose(point.advance(2.0)[0], GOAL)


def test_a_new_trajectory_goes_on_from_the_set_point_without_a_jump():
    point = setpoint()
    point.take(0.0, JOINTS, [2.0], [GOAL], [[0.0, 0.0]], [[0.0, 0.0]])
    before = point.advance(0.9).copy()
    point.take(0.9, JOINTS, [1.5], [START], [[0.0, 0.0]], [[0.0, 0.0]])
    np.testing.assert_allclose(point.advance(0.9), before, atol=1e-9)
    np.testing.assert_allclose(point.advance(0.901)[1], before[1], atol=5e-3)
    np.testing.assert_allclose(point.advance(3.0)[0], START)


REFUSED = {
    'empty': ((JOINTS, [], []), 'empty'),
    'unknown joint': ((('a', 'x'), [1.0], [GOAL]), 'joints'),
    'missing joint': ((('a',), [1.0], [[0.5]]), 'joints'),
    'joint twice': ((('a', 'b', 'b'), [1.0], [[0.5, 0.4, 0.4]]), 'joints'),
    'wrong width': ((JOINTS, [1.0], [[0.5]]), 'positions'),
    'wrong length': ((JOINTS, [1.0, 2.0], [GOAL]), 'positions'),
    'ragged': ((JOINTS, [1.0, 2.0], [[0.5, 0.4], [0.5]]), 'positions'),
    'not a number': ((JOINTS, [1.0], [[0.5, np.nan]]), 'finite'),
    'backward time': ((JOINTS, [1.0, 0.5], [GOAL, GOAL]), 'increasing'),
    'negative time': ((JOINTS, [-1.0], [GOAL]), 'times'),
    'ends moving': ((JOINTS, [1.0], [GOAL], [[0.1, 0.0]]), 'standstill'),
    'beyond a stop': ((JOINTS, [1.0, 2.0], [GOAL, [9.0, 0.4]]),
                      'a is sent to 9; allowed: -2.97 to 2.97'),
    'beyond the other': ((JOINTS[::-1], [1.0], [[0.0, -3.0]]), 'a is sent to -3'),
    'wrong velocities': ((JOINTS, [1.0], [GOAL], [[0.0]]), 'velocities'),
}


@pytest.mark.parametrize('case', REFUSED)
def test_what_is_refused_leaves_the_motion_as_it_was(case):
    arguments, sentence = REFUSED[case]
    point, same = setpoint(), setpoint()
    for each in (point, same):
        each.take(0.0, JOINTS, [2.0], [GOAL], [[0.0, 0.0]])
        each.advance(0.5)
    with pytest.raises(TrajectoryError, match=sentence):
        point.take(0.5, *arguments)
    np.testing.assert_array_equal(point.advance(1.0), same.advance(1.0))


def test_the_plant_refuses_with_a_value_error():
    plant = Plant(ur10e())
    with pytest.raises(ValueError, match='empty'):
        plant.set_trajectory(ur10e().joints, [], [])
    assert not plant.moving


def test_the_plant_obeys_up_to_the_limits_of_the_urdf():
    plant, limits = Plant(ur10e()), ur10e().limits
    for goal in (limits.upper, limits.lower):
        plant.set_trajectory(ur10e().joints, [5.0], [goal])
        with pytest.raises(TrajectoryError, match='shoulder_pan_joint.*the limits of the URDF'):
            plant.set_trajectory(ur10e().joints, [5.0], [goal * [1.01, 1.0, 1.0, 1.0, 1.0, 1.0]])


def test_a_continuous_joint_may_turn_on():
    content = {**chain('z', 'y', 'x').file.content}
    content['urdf'] = content['urdf'].replace('type="revolute"', 'type="continuous"', 1).replace(
        'lower="-2.5" upper="2.5"', '', 1)
    plant = Plant(robot_from_content(content, 'test'))
    plant.set_trajectory(plant.robot.joints, [5.0], [[9.0, 0.0, 0.0]])
    with pytest.raises(TrajectoryError, match='j1 is sent to 9'):
        plant.set_trajectory(plant.robot.joints, [5.0], [[0.0, 9.0, 0.0]])


def test_a_single_point_at_time_zero_is_reached():
    plant = Plant(ur10e())
    plant.set_trajectory(ur10e().joints, [0.0], [np.full(6, 0.01)])
    plant.step_until(1.5)
    np.testing.assert_allclose(plant.state()[0], 0.01, atol=1e-3)
