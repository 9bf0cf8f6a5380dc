"""Where the two torques come from: the nominal one from motion, the actual one from the drives."""

from dataclasses import replace

from core_helpers import block, exact_model, feed, four_axes, messages, pipeline_of, warm
import numpy as np
import pinocchio as pin
import pytest

from hand_load_estimator.identification import nominal_model
from hand_load_estimator.torque_columns import real_torque

CONSTANTS = [11.0, -9.0, 8.0, 5.0]
MOTION = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 4))


def test_e1_1_nominal_torque_is_inverse_dynamics_of_the_nominal_parameters():
    """tau_mdl of the robot file's parameters is rnea's; other parameters give another torque."""
    robot = four_axes()
    model = nominal_model(robot, np.full(4, 0.01))
    q, v, a = MOTION
    wanted = pin.rnea(robot.model, robot.model.createData(), q, v, a)
    np.testing.assert_allclose(model.torque(q, v, a), wanted, atol=1e-9)
    heavier = model.mean.copy()
    heavier[:40] *= 1.1
    np.testing.assert_allclose(replace(model, mean=heavier).torque(q, v, a), 1.1 * wanted,
                               atol=1e-9)


@pytest.mark.parametrize('kind', ['motor_torque', 'link_torque', 'motor_current'])
def test_e1_2_actual_torque_is_current_times_constant_or_the_sensors(kind):
    effort = {'kind': kind, 'includes_configured_load': False}
    if kind == 'motor_current':
        effort.update(torque_constants=CONSTANTS, torque_constants_std=0.05)
    robot = four_axes(effort=effort)
    reported = np.array([1.0, 2.0, -3.0, 0.5])
    factor = CONSTANTS if kind == 'motor_current' else np.ones(4)
    np.testing.assert_allclose(real_torque(robot, MOTION[0], reported), reported * factor)


def test_e1_2_a_load_the_controller_has_taken_off_is_put_back():
    known = {'mass': 2.0, 'com': [0.0, 0.0, 0.1]}
    robot = four_axes(effort={'kind': 'motor_torque', 'includes_configured_load': True,
                              'configured_load': known})
    q, zero = MOTION[0], np.zeros(4)
    weight = robot.load_regressor(q, zero, zero)[:, :4] @ [2.0, 0.0, 0.0, 0.2]
    np.testing.assert_allclose(real_torque(robot, q, np.zeros(4)), weight)


@pytest.mark.parametrize('robot_name', ['ur10e_current', 'ur10e'])
def test_e1_2_currents_and_torques_give_the_same_load(robot_name):
    model = exact_model(robot_name)
    last = feed(warm(pipeline_of(model)), messages(model, block(3.0), 4.0))[-1]
    assert abs(last.mean[0] - 3.0) < min(3.5 * last.std[0], 0.3)


def test_e1_2_positions_may_be_the_commanded_ones():
    """The arm follows 8 ms behind; messages hold the command, and no velocity is commanded."""
    model = exact_model('ur10e')
    sent = messages(model, block(3.0), 6.0, rate=125.0)
    commanded = [replace(m, position=ahead.position, velocity=np.array([]))
                 for m, ahead in zip(sent, sent[1:])]
    measured, by_command = (feed(warm(pipeline_of(model)), stream)[-1]
                            for stream in (sent, commanded))
    print(measured.mean[:4], by_command.mean[:4], by_command.std[:4], by_command.status)
    assert abs(by_command.mean[0] - measured.mean[0]) < 0.01 * model.robot.rated_load.mass
