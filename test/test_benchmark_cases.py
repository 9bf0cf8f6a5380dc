"""Cases belong to their seeds, and their clock starts with a joint that carries the load."""

from dataclasses import replace

from core_helpers import four_axes
import numpy as np
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import cases
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.plant import JointEvent, TemperatureEvent
from hand_load_estimator.recording import JointSample
from hand_load_estimator.robot import load_robot


def test_a_case_belongs_to_its_seed_and_is_a_body():
    robot = four_axes()
    drawn = [cases.draw_case(robot, 1000, seed) for seed in range(50)]
    again = cases.draw_case(robot, 1000, 7)
    np.testing.assert_array_equal(again.load.to_message(), drawn[7].load.to_message())
    assert all(case.load.is_physical() for case in drawn)
    masses = [case.load.mass for case in drawn]
    heaviest = 10.0 / 12.5 * robot.rated_load.mass
    assert 0.8 * heaviest < max(masses) <= heaviest and min(masses) < 0.2 * heaviest
    assert {0.3 <= case.speed <= 1.0 and 15.0 <= case.temperature <= 50.0 for case in drawn} \
        == {True}


def test_motion_start_is_the_first_move_of_a_joint_that_gravity_loads():
    """Joint 1 turns about the vertical and tells nothing of the load's weight."""
    robot, zero, q = four_axes(), np.zeros(4), np.array([0.0, 0.8, 0.3, 0.2])

    def sample(t, v):
        return JointEvent(t, q, np.array(v), zero)

    # A chain whose first axis is upright only roughly: take what gravity really loads.
    torque = np.abs(robot.load_regressor(q, zero, zero) @ robot.rated_load.to_products())
    loaded = int(np.argmax(torque))
    free = [j for j in range(4) if torque[j] < 0.1 * torque.max()]
    slow, fast = np.eye(4)[loaded] * 0.04, np.eye(4)[loaded] * 0.06
    samples = [TemperatureEvent(0.0, zero), sample(0.0, zero), sample(0.1, slow),
               sample(0.3, fast)]
    for j in free:
        samples.insert(2, sample(0.05, np.eye(4)[j]))
    assert cases.motion_start(robot, samples) == 0.3
    assert cases.motion_start(robot, samples[:-1]) is None


@pytest.mark.parametrize('joint', range(6))
def test_the_clock_of_a_six_axis_arm_starts_with_joints_two_to_four(joint):
    """Wrist 2 carries weight in most poses, and starts no clock (DESIGN section 6)."""
    robot = load_robot(find_shared('ur10e', 'robots'))
    q, zero = np.array([0.0, -1.2, 1.5, 0.4, 0.6, 0.3]), np.zeros(6)
    moving = JointEvent(0.2, q, 0.06 * np.eye(6)[joint], zero)
    start = cases.motion_start(robot, [JointEvent(0.0, q, zero, zero), moving])
    assert start == (0.2 if 1 <= joint <= 3 else None)
    if joint == 4:
        assert robot.gravity_loaded(q)[joint]


def test_the_clock_starts_with_what_is_measured_and_not_with_the_filter():
    robot = load_robot(find_shared('ur10e', 'robots'))
    case = cases.draw_case(robot, seeds.DEVELOPMENT_PLANTS[93], seeds.DEVELOPMENT_CASES[996])
    events = list(cases.case_events(robot, case))
    run = cases.case_run(robot, case)
    states = [e for e in events if isinstance(e, JointEvent)]
    first = next(e for e in states if (np.abs(e.velocity[1:4]) > cases.MOTION_START).any())
    filtered = next(s for s in run.samples if (np.abs(s.v[1:4]) > cases.MOTION_START).any())
    assert run.start == first.stamp < filtered.stamp - 0.02


def test_the_clock_reads_recordings_by_joint_names():
    robot = load_robot(find_shared('ur10e', 'robots'))
    q = np.array([0.0, -1.2, 1.5, 0.4, 0.6, 0.3])
    names, velocity = tuple(reversed(robot.joints)), 0.06 * np.eye(6)[2]
    rows = [JointSample(stamp, names, q[::-1], v[::-1], np.zeros(6))
            for stamp, v in ((1.0, 0 * velocity), (1.01, velocity))]
    assert cases.motion_start(robot, rows) == 1.01
    assert cases.motion_start(robot, [replace(row, velocity=np.array([])) for row in rows]) is None
