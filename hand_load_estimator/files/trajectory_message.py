"""Write a trajectory as the YAML of a trajectory_msgs/JointTrajectory."""

import json
from pathlib import Path

import numpy as np

# [s] between points; the controller's quintic splines join them.
_SPACING = 0.04


def _numbers(values):
    return '[' + ', '.join(f'{value:.7f}' for value in values) + ']'


def write_trajectory_message(path, joints, trajectory):
    """Write the message: the first point is the start at rest, a point every 40 ms."""
    count = int(np.ceil(trajectory.duration / _SPACING))
    times = np.linspace(trajectory.start, trajectory.end, count + 1)
    lines = ['header: {frame_id: ""}', f'joint_names: {json.dumps(list(joints))}', 'points:']
    for t, q, v, a in zip(times, *trajectory.sample(times)):
        nanoseconds = round((t - trajectory.start) * 1e9)
        lines.append(f'- {{positions: {_numbers(q)}, velocities: {_numbers(v)}, '
                     f'accelerations: {_numbers(a)}, time_from_start: '
                     f'{{sec: {nanoseconds // 10**9}, nanosec: {nanoseconds % 10**9}}}}}')
    Path(path).write_text('\n'.join(lines) + '\n', encoding='utf-8')
