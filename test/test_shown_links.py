"""The links' torque behind the motion filter: what a load weighs while the arm is in motion."""

from dataclasses import fields, replace

import numpy as np
import pytest

from hand_load_estimator.motion import Motion, MotionFilter
from hand_load_estimator.robot import load_robot
from hand_load_estimator.simulation.simulate_motions import named_motion
from hand_load_estimator.torque.shown_links import shown_links

RATE = 500.0
LOAD = np.array([5.0, 0.15, 0.1, 0.5, 0.06, 0.0, 0.06, 0.0, 0.0, 0.03])


def filtered(robot, duration, speed):
    """Return the Motion of a quick arm that holds LOAD, without friction or noise."""
    trajectory = named_motion('excite', robot, duration, speed, 3)
    motion_filter, samples = MotionFilter(robot.n), []
    for t in np.arange(0.0, duration, 1.0 / RATE):
        q, v, a = trajectory.sample(t)
        samples.append(motion_filter.update(t, q, v, robot.load_regressor(q, v, a) @ LOAD))
    return Motion.of([s for s in samples if s is not None])


@pytest.fixture(scope='module')
def robot():
    return load_robot('config/robots/ur10e.yaml')


def test_torque_of_a_load_is_what_the_filter_shows(robot):
    motion = filtered(robot, 12.0, 1.0)
    shown = robot.load_columns(shown_links(robot, motion))
    plain = np.array([robot.load_regressor(*row) for row in zip(motion.q, motion.v, motion.a)])
    off, before = (np.sqrt(np.mean((motion.effort - columns @ LOAD) ** 2, axis=0))
                   for columns in (shown, plain))
    assert (off < 0.15 * before).all()
    # The plain regressor sees a moving weight too heavy, so that it finds too little of it.
    found = [np.linalg.lstsq(columns.reshape(-1, 10), motion.effort.ravel(), rcond=None)[0][0]
             for columns in (shown, plain)]
    assert abs(found[0] - 5.0) < 2e-6 and found[1] - 5.0 < -1e-4


def test_motion_that_no_filter_smoothed_is_taken_as_it_is(robot):
    motion = filtered(robot, 2.0, 0.5)
    plain = replace(motion, jerk=None)
    rows = [robot.link_regressor(*row) for row in zip(motion.q, motion.v, motion.a)]
    assert np.array_equal(shown_links(robot, plain), np.array(rows))


def test_parts_of_a_motion_keep_all_of_it(robot):
    motion = filtered(robot, 2.0, 0.5)
    part = motion.part(slice(10, 20))
    assert np.array_equal(part.jerk, motion.jerk[10:20]) and len(part.stamp) == 10
    plain = replace(motion, jerk=None)
    for whole in (motion, plain):
        again = Motion.of(whole.samples())
        for name in (field.name for field in fields(Motion)):
            value = getattr(whole, name)
            assert (value is None and getattr(again, name) is None or np.array_equal(
                getattr(again, name), value, equal_nan=True)), name
