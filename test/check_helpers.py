"""Recordings made up for `hand_load check`, and what it says of them."""

from pathlib import Path

import numpy as np
import pinocchio as pin

from hand_load_estimator.checks.recording_check import check_recording
from hand_load_estimator.files.robot_file import parse_robot
from hand_load_estimator.recording import JointSample, Recording, TemperatureSample
from hand_load_estimator.robot import Robot

RATE = 100.0
CENTRE = np.array([0.3, -1.4, 1.0, -1.2, -1.4, 0.2])
FRICTION, VISCOUS = (np.array([9.0, 9.0, 5.0, 2.0, 2.0, 2.0]) * k for k in (1.0, 1.2))


def swings():
    """Return t (N,) and q, v, a (N, 6) of a motion of all joints."""
    random = np.random.default_rng(4)
    t = np.arange(0.0, 24.0, 1.0 / RATE)
    q, v, a = (np.zeros((len(t), 6)) for _ in range(3))
    for k in range(1, 6):
        w = 2.0 * np.pi * 0.07 * k
        size, phase = random.uniform(0.1, 0.35, 6), random.uniform(0.0, 6.3, 6)
        q += size * np.sin(w * t[:, None] + phase)
        v += size * w * np.cos(w * t[:, None] + phase)
        a -= size * w * w * np.sin(w * t[:, None] + phase)
    return t, q + CENTRE, v, a


def torque(robot, motion, gravity=None, load=None, friction=1.0):
    _, q, v, a = motion
    model = pin.Model(robot.model)
    if gravity is not None:
        model.gravity.linear = np.array(gravity)
    data = model.createData()
    tau = np.array([pin.rnea(model, data, *sample).copy() for sample in zip(q, v, a)])
    if load is not None:
        tau += np.array([robot.load_regressor(*s) @ load.to_products() for s in zip(q, v, a)])
    noise = np.random.default_rng(0).standard_normal(q.shape) * [1.2, 1.2, 0.9, 0.35, 0.35, 0.35]
    return tau + friction * (FRICTION * np.tanh(v / 0.01) + VISCOUS * v) + noise


def recording(robot, motion, effort, load=None, known=(), temperature=30.0, names=None):
    t, q, v, _ = motion
    samples = []
    for k, stamp in enumerate(t):
        samples.append(JointSample(stamp, names or robot.joints, q[k], v[k], effort[k]))
        if k % 10 == 0 and temperature is not None:
            samples += [TemperatureSample(stamp, joint, temperature) for joint in robot.joints]
    return Recording(Path('made'), samples, load, known)


def verdicts(robot, made):
    return {f.item: f.verdict for f in check_recording(made, robot).findings}


def only(found, **expected):
    """Assert the verdicts named, with spaces for underscores, and ok for all others."""
    wanted = {name.replace('_', ' '): verdict for name, verdict in expected.items()}
    assert wanted.keys() <= found.keys()
    assert {k: v for k, v in found.items() if v != 'ok'} == wanted


def changed_robot(robot, **changes):
    return Robot(parse_robot({**robot.file.content, **changes}, 'changed'))
