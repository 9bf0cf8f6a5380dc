"""The whole arm: reproducible, follows within milliradians, sticks, reports what is stated."""

from dataclasses import replace
import time

from hand_load_estimator.load import LoadParameters
from hand_load_estimator.plant import Plant, simulate_motion
from hand_load_estimator.plant.difficulty import DEFAULT
from hand_load_estimator.plant.run import collect
import numpy as np
from plant_helpers import chain, LOAD, sweep, ur10e, ur10e_with_effort
import pytest

FRICTIONLESS = replace(DEFAULT, coulomb=(0.0,) * 3, viscous=(0.0,) * 3)
QUIET = replace(DEFAULT, torque_noise=(1e-9,) * 3, position_noise=0.0, position_quantum=0.0,
                velocity_noise=0.0)


def measured(robot, seed=0, duration=3.0, **arguments):
    return collect(simulate_motion(robot, *sweep(robot, duration, 0.4), seed=seed,
                                   **arguments))


def test_the_same_seed_gives_the_same_data():
    one, other = (measured(ur10e(), 3, load=LOAD) for _ in range(2))
    for a, b in zip(one, other):
        np.testing.assert_array_equal(a, b)


def test_another_seed_gives_another_arm():
    one, other = (measured(ur10e(), seed)[3].mean(axis=0) for seed in (3, 4))
    assert np.all(one != other)
    # J2 holds 120 Nm of arm: masses and centres within 8 % each, friction left at rest.
    assert 0.1 < abs(one[1] - other[1]) < 40.0


def test_it_follows_within_milliradians_and_never_leaves_the_numbers():
    robot = ur10e()
    t, q, v, a = sweep(robot, 20.0, 1.0)
    stamp, position, velocity, effort, celsius = collect(
        simulate_motion(robot, t, q, v, a, seed=1, load=LOAD, settle=0.5))
    for values in (position, velocity, effort, celsius):
        assert np.all(np.isfinite(values))
    wanted = np.array([np.interp(stamp - 0.5, t, column) for column in q.T]).T
    error = np.abs(position - wanted)
    assert np.all(error.max(axis=0) < 0.01) and error.max() > 1e-4
    assert stamp[-1] == pytest.approx(20.5) and len(stamp) == 10251


@pytest.mark.parametrize('make', [lambda: chain('z', 'y', 'y', 'x'), lambda: chain(*'zyzyzyz'),
                                  lambda: chain('z', 'z', 'prismatic z', 's')])
def test_other_arms_follow_too(make):
    robot = make()
    t, q, v, a = sweep(robot, 6.0, 0.1)
    _, position, _, effort, _ = collect(simulate_motion(robot, t, q, v, a, seed=1))
    assert np.all(np.isfinite(effort))
    assert np.all(np.abs(position[-1] - q[-1]) < 0.01)


def test_at_rest_it_sticks_with_friction_nobody_can_see():
    """The effort at rest is gravity and a part of static friction that differs by seed."""
    left = []
    for seed in range(6):
        plant = Plant(ur10e(), seed=seed)
        before = plant.state()[0]
        plant.step_until(1.0)
        assert np.all(np.abs(plant.state()[0] - before) < 1e-6)
        left.append(plant.friction_torque()[0] / plant.truth.friction.coulomb[0])
    assert np.ptp(left) > 0.5 and np.all(np.abs(left) < 1.3)


def test_a_light_touch_does_not_move_a_stuck_joint():
    """A load whose weight is far below static friction bends the bristles, no more."""
    plant = Plant(ur10e(), seed=2)
    before = plant.state()[0]
    plant.attach(LoadParameters(0.05, [0.0, 0.0, 0.05]))
    plant.step_until(3.0)
    assert np.all(np.abs(plant.state()[0] - before) < 1e-3)


def test_attaching_a_load_changes_the_effort_by_its_weight():
    robot = ur10e()
    plant = Plant(robot, seed=5, difficulty=FRICTIONLESS)
    plant.step_until(0.5)
    empty = plant.state()[3]
    plant.attach(LOAD)
    plant.step_until(3.0)
    q, rest = plant.state()[0], np.zeros(6)
    weight = robot.load_regressor(q, rest, rest) @ LOAD.to_products()
    np.testing.assert_allclose(plant.state()[3] - empty, weight, atol=0.05)
    assert plant.true_load is LOAD
    plant.attach(None)
    assert plant.true_load.mass == 0.0


def test_noise_is_what_the_design_states():
    plant = Plant(ur10e(), seed=0)
    values = np.array([plant.measure() for _ in range(4000)])
    position, velocity, effort = np.std(values, axis=0)
    np.testing.assert_allclose(effort, [1.2, 1.2, 0.9, 0.35, 0.35, 0.35], rtol=0.08)
    np.testing.assert_allclose(velocity, 2e-3, rtol=0.08)
    assert np.all(position < 2e-5)
    lag = effort.reshape(6) * 0.0 + [np.corrcoef(values[1:, 2, j], values[:-1, 2, j])[0, 1]
                                     for j in range(6)]
    assert np.all(np.abs(lag) < 0.06)


def test_temperatures_are_noisy_stepped_and_near_the_start():
    plant = Plant(ur10e(), seed=0, start_temperature=40.0)
    values = np.array([plant.measure_temperatures() for _ in range(500)])
    assert np.all(np.abs(values.mean(axis=0) - 40.0) < 1.2)
    np.testing.assert_allclose(values * 10.0, np.round(values * 10.0), atol=1e-6)
    assert np.all(values.std(axis=0) > 0.05) and np.all(values.std(axis=0) < 0.12)


def test_moving_warms_the_joints_and_a_warm_arm_cools():
    robot = ur10e()
    moving = Plant(robot, seed=0)
    moving.set_trajectory(robot.joints, *sweep(robot, 10.0, 1.2))
    still = Plant(robot, seed=0, start_temperature=45.0, ambient_temperature=20.0)
    cold, warm = moving.true_temperatures()[0], still.true_temperatures()[0]
    for plant in (moving, still):
        plant.step_until(10.0)
    assert np.all(moving.true_temperatures()[0] > cold + 0.02)
    assert np.all(still.true_temperatures()[0] < warm - 0.02)


def test_a_motor_current_is_the_torque_over_a_constant_within_its_doubt():
    robot = ur10e('ur10e_current')
    plant = Plant(robot, seed=1, difficulty=QUIET)
    ratio = plant.state()[3] / plant.measure()[2]
    doubt = np.abs(ratio / robot.file.effort.torque_constants - 1.0)
    assert np.all(doubt < 2.0 * robot.file.effort.torque_constants_std + 1e-6)
    assert np.any(doubt > 1e-3)


def test_a_link_torque_has_neither_friction_nor_rotor():
    robot = ur10e_with_effort(kind='link_torque')
    plant = Plant(robot, seed=1, difficulty=QUIET, load=LOAD)
    plant.set_trajectory(robot.joints, *sweep(robot, 4.0, 0.5))
    plant.step_until(1.3)
    q, v, a, reported = plant.state()
    links = np.concatenate([_products(link) for link in plant.truth.links])
    expected = robot.link_regressor(q, v, a) @ links \
        + robot.load_regressor(q, v, a) @ LOAD.to_products()
    np.testing.assert_allclose(reported, expected, atol=1e-6)
    np.testing.assert_allclose(plant.measure()[2], expected, atol=1e-4)


def test_a_configured_load_is_taken_off_the_effort():
    entry = {'mass': 3.0, 'com': [0.0, 0.02, 0.1]}
    plain = ur10e()
    configured = ur10e_with_effort(includes_configured_load=True, configured_load=entry)
    one, other = (Plant(robot, seed=1, difficulty=QUIET) for robot in (plain, configured))
    load, rest = configured.file.effort.configured_load, np.zeros(6)
    weight = plain.load_regressor(one.state()[0], rest, rest) @ load.to_products()
    np.testing.assert_allclose(one.measure()[2] - other.measure()[2], weight, atol=1e-4)


@pytest.mark.parametrize('rate', [30.0, 125.0, 500.0, 1000.0])
def test_the_clock_keeps_any_rate(rate):
    plant = Plant(ur10e(), rate=rate)
    for _ in range(10):
        plant.step()
    assert plant.time == pytest.approx(10.0 / rate, abs=1e-9)


def test_drives_do_not_exceed_their_peak():
    robot = ur10e()
    plant = Plant(robot, load=LoadParameters(40.0, [0.0, 0.0, 0.2]))
    plant.step_until(0.2)
    assert np.all(np.abs(plant.state()[3]) <= robot.file.max_torque + 1e-9)
    assert np.abs(plant.state()[3][1]) == pytest.approx(330.0)


def test_it_is_many_times_faster_than_real_time():
    """Ten times is the aim on a free core; twice must hold on a busy one."""
    robot = ur10e()
    plant = Plant(robot)
    plant.set_trajectory(robot.joints, *sweep(robot, 4.0, 0.5))
    began = time.process_time()
    plant.step_until(4.0)
    assert 4.0 / (time.process_time() - began) > 2.0


def _products(pseudo):
    tensor = np.trace(pseudo[:3, :3]) * np.eye(3) - pseudo[:3, :3]
    return np.array([pseudo[3, 3], *pseudo[:3, 3], tensor[0, 0], tensor[0, 1], tensor[1, 1],
                     tensor[0, 2], tensor[1, 2], tensor[2, 2]])
