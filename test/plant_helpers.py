"""Arms for the plant's tests: the shipped UR10e and small chains of any number of axes."""

from functools import lru_cache
from pathlib import Path

from hand_load_estimator.load import LoadParameters
from hand_load_estimator.plant.effects_file import parse_effects
from hand_load_estimator.robot import load_robot, robot_from_content
import numpy as np

ROBOTS = Path(__file__).resolve().parent.parent / 'config' / 'robots'
LOAD = LoadParameters(6.0, [0.03, -0.05, 0.11], [[0.05, 0.01, -0.004], [0.01, 0.04, 0.006],
                                                 [-0.004, 0.006, 0.03]])


@lru_cache
def ur10e(name='ur10e'):
    """Return a shipped robot."""
    return load_robot(ROBOTS / f'{name}.yaml')


def ur10e_with_effort(**effort):
    """Return a UR10e with other content under `effort`."""
    content = {**ur10e().file.content}
    content['effort'] = {**content['effort'], **effort}
    return robot_from_content(content, 'test')


def chain_urdf(axes):
    """Return a URDF of a serial chain; axes: strings as `y` or `prismatic z`."""
    parts = ['<robot name="chain"><link name="base"/>']
    parent = 'base'
    for k, axis in enumerate(axes):
        kind = 'prismatic' if axis.startswith('prismatic') else 'revolute'
        xyz = {'x': '1 0 0', 'y': '0 1 0', 'z': '0 0 1', 's': '0.6 0 0.8'}[axis[-1]]
        reach = '0.15' if kind == 'prismatic' else '2.5'
        parts.append(
            f'<joint name="j{k}" type="{kind}"><parent link="{parent}"/><child link="l{k}"/>'
            f'<origin xyz="0.02 0.1 0.2" rpy="0.1 0 0.2"/><axis xyz="{xyz}"/>'
            f'<limit lower="-{reach}" upper="{reach}" effort="60" velocity="2"/></joint>'
            f'<link name="l{k}"><inertial><mass value="{3.0 / (k + 1)}"/>'
            '<origin xyz="0.01 0.03 0.1" rpy="0.3 0.2 0.1"/>'
            '<inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.015" iyz="0.002" izz="0.01"/>'
            '</inertial></link>')
        parent = f'l{k}'
    parts.append(f'<link name="tip"/><joint name="fixed" type="fixed"><parent link="{parent}"/>'
                 '<child link="tip"/><origin xyz="0 0.05 0.1" rpy="0.5 0.2 0"/></joint></robot>')
    return ''.join(parts)


def chain(*axes):
    """Return a Robot of a small chain with drives of 20 to 60 Nm."""
    n = len(axes)
    return robot_from_content({
        'name': f'chain{n}', 'urdf': chain_urdf(axes), 'joints': [f'j{k}' for k in range(n)],
        'load_frame': 'tip', 'gravity': [0.0, 0.0, -9.81], 'reference_temperature': 25.0,
        'rated_load': {'mass': 1.0, 'com': [0.0, 0.0, 0.05]},
        'effort': {'kind': 'motor_torque', 'includes_configured_load': False},
        'max_velocity': [2.0] * n, 'max_acceleration': [6.0] * n,
        'max_torque': np.linspace(60.0, 20.0, n).tolist()}, 'chain')


def effects(robot, *entries):
    """Return the requests of effects given as mappings."""
    return parse_effects([dict(entry) for entry in entries], robot)


def sweep(robot, duration=10.0, amplitude=0.8, knots=0.02):
    """Return time (k,), q, v, a (k, n): a smooth sweep that starts and ends at rest."""
    t = np.linspace(0.0, duration, int(duration / knots) + 1)
    rate = 2.0 * np.pi / duration * np.arange(2, 2 + robot.n)
    q = amplitude * (1.0 - np.cos(rate * t[:, None])) / 2.0
    v = amplitude * rate * np.sin(rate * t[:, None]) / 2.0
    return t, q, v, amplitude * rate ** 2 * np.cos(rate * t[:, None]) / 2.0
