"""The same planning for arms that are no UR10e: four and seven axes."""

import numpy as np
import pytest

from hand_load_estimator.control.acceleration_limits import MovePlanner
from hand_load_estimator.control.collision_threshold import CollisionThresholds
from hand_load_estimator.control.load_belief import belief_of_estimate, rated_belief
from hand_load_estimator.identification.identify import nominal_model
from hand_load_estimator.robot import robot_from_content

LINK = ('<link name="l{i}"><inertial><origin xyz="0 0 0.15"/><mass value="{m}"/>'
        '<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>')
JOINT = ('<joint name="j{i}" type="revolute"><parent link="l{p}"/><child link="l{i}"/>'
         '<origin xyz="0 0 0.3"/><axis xyz="{axis}"/>'
         '<limit lower="-3" upper="3" effort="100" velocity="3"/></joint>')


def arm(n, torque):
    """Return the Robot of a chain of n links that turn about z and y in turn."""
    parts = [LINK.format(i=0, m=5.0)]
    for i in range(1, n + 1):
        parts.append(LINK.format(i=i, m=round(4.0 / i, 2)))
        parts.append(JOINT.format(i=i, p=i - 1, axis='0 0 1' if i % 2 else '0 1 0'))
    return robot_from_content({
        'name': f'chain{n}', 'urdf': f'<robot name="c">{"".join(parts)}</robot>',
        'joints': [f'j{i}' for i in range(1, n + 1)], 'load_frame': f'l{n}',
        'gravity': [0.0, 0.0, -9.81], 'reference_temperature': 25.0,
        'rated_load': {'mass': 3.0, 'com': [0.0, 0.0, 0.1],
                       'inertia': [0.01, 0, 0, 0.01, 0, 0.01]},
        'effort': {'kind': 'motor_torque', 'includes_configured_load': False},
        'max_velocity': [2.0] * n, 'max_acceleration': [20.0] * n,
        'max_torque': [torque] * n}, 'test')


@pytest.mark.parametrize('n, torque', [(4, 24.0), (7, 90.0)])
def test_limits_and_thresholds_for_any_number_of_joints(n, torque):
    robot = arm(n, torque)
    model = nominal_model(robot, np.full(n, 0.001))
    planner, warm = MovePlanner(model), np.full(n, np.nan)
    start, goal = np.full(n, 0.2), np.linspace(1.0, -0.6, n)
    vector = np.array([1.0, 0.0, 0.0, 0.1] + [0.01, 0.0, 0.0, 0.01, 0.0, 0.01])
    light = belief_of_estimate(vector, 1e-4 * np.eye(10))
    known = planner.plan(start, goal, light, warm)
    rated = planner.plan(start, goal, rated_belief(robot), warm)
    assert known.feasible and rated.feasible and known.duration < rated.duration
    assert planner.use(known, light, warm) <= 1.005
    state = [x[0] for x in known.points([0.2])]
    now, fixed = CollisionThresholds(model).at(*state, light, warm)
    assert now.threshold.shape == (n,) and np.all(now.threshold <= fixed)
