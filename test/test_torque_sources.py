"""Where the two torques come from: the nominal one from motion, the actual one from the drives."""

from dataclasses import replace

from core_helpers import (block, EFFECTS, exact_model, feed, four_axes, messages, pipeline_of,
                          recording_of, warm)
import numpy as np
import pinocchio as pin
from pipeline_helpers import within
import pytest
import yaml

from hand_load_estimator.checks.recording_check import check_recording
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.identification.identify import nominal_model
from hand_load_estimator.robot import robot_from_content
from hand_load_estimator.stream.commanded_positions import CommandedPositions
from hand_load_estimator.torque.columns import real_torque
from hand_load_estimator.torque.model_file import write_model

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


@pytest.mark.parametrize('names', [('torque_offset',), EFFECTS])
def test_e1_2_a_minute_at_one_pose_tells_no_more_than_a_second(names):
    """What a model is off by at a pose stays: behind a torque sensor as where friction holds."""
    pipeline = warm(pipeline_of(exact_model('four', names)))
    standing = feed(pipeline, messages(pipeline.model, block(3.0), 40.0, rest=99.0))
    early, late = (next(e for e in standing if e.stamp >= standing[0].stamp + seconds)
                   for seconds in (3.0, 38.0))
    assert late.std[0] > 0.8 * early.std[0]


def test_a_load_taken_after_a_long_rest_behind_torque_sensors_is_known_at_once():
    pipeline = warm(pipeline_of(exact_model('four', ('torque_offset',))))
    standing = feed(pipeline, messages(pipeline.model, block(3.0), 40.0, rest=99.0,
                                       change=(30.0, block(5.0))))
    assert {e.load_id for e in standing if e.stamp < 129.9} == {0} and standing[-1].load_id == 1
    soon = next(e for e in standing if e.stamp > 132.0)
    assert within(soon, block(5.0)) and soon.std[0] < 0.2


LAG = 0.012   # [s] the arm is behind its commands


def commanded(model, seconds=6.0, rate=125.0, velocity=True):
    """Return what is measured of an arm with 3 kg, and the same with commands for positions."""
    sent = messages(model, block(3.0), seconds, rate=rate)
    stamps, q, v = (np.array([getattr(m, name) for m in sent])
                    for name in ('stamp', 'position', 'velocity'))
    ahead = [np.array([np.interp(stamps + LAG, stamps, column) for column in values.T]).T
             for values in (q, v)]
    return sent, [replace(m, position=q, velocity=v if velocity else np.array([]))
                  for m, q, v in zip(sent, *ahead)]


def with_position(model, **position):
    """Return a TorqueModel whose robot file says where positions come from."""
    robot = robot_from_content({**model.robot.file.content, 'position': position}, 'commanded')
    return replace(model, robot=robot)


@pytest.mark.parametrize('velocity', [True, False])
def test_e1_2_positions_may_be_the_commanded_ones(velocity):
    """Told how far the arm is behind, the estimate is that of measured positions."""
    model = exact_model('ur10e')
    told = with_position(model, source='command', lag=LAG)
    sent, ahead = commanded(model, velocity=velocity)
    measured, by_command, untold = (
        feed(warm(pipeline_of(which)), stream)[-1]
        for which, stream in ((model, sent), (told, ahead), (model, ahead)))
    off, off_untold = (np.abs(which.mean[:4] - measured.mean[:4]) / measured.std[:4]
                       for which in (by_command, untold))
    assert off.max() < 1.0 < off_untold.max()
    assert not np.any(np.abs(by_command.mean[:4] - block(3.0).to_message()[:4])
                      > 3.0 * by_command.std[:4])


@pytest.mark.parametrize('position, said', [
    ({'source': 'wish'}, 'source'), ({'source': 'command'}, 'lag'),
    ({'source': 'command', 'lag': -0.1}, 'lag'), ({'source': 'command', 'lag': 1.0}, 'lag'),
    ({'source': 'feedback', 'lag': 0.01}, 'lag')])
def test_e1_2_a_position_that_means_nothing_is_refused(position, said):
    with pytest.raises(ConfigurationError, match=said):
        with_position(exact_model('four'), **position)


def test_e1_2_measured_positions_are_the_rule():
    assert exact_model('four').robot.file.command_lag is None
    assert with_position(exact_model('four'), source='feedback').robot.file.command_lag is None


def test_e1_2_commands_are_held_back_and_efforts_are_not():
    commands = CommandedPositions(0.015)
    seen = [commands.update(0.01 * k, np.array([[k], [10.0 * k], [100.0 * k]], dtype=float))
            for k in range(6)]
    np.testing.assert_allclose(np.array(seen)[:, :, 0], [
        [0.0, 0.0, 0.0], [0.0, 0.0, 100.0], [0.5, 5.0, 200.0], [1.5, 15.0, 300.0],
        [2.5, 25.0, 400.0], [3.5, 35.0, 500.0]], atol=1e-9)
    commands.restart()
    assert commands.update(9.0, np.full((3, 1), 7.0)).ravel().tolist() == [7.0, 7.0, 7.0]


def test_e1_2_a_model_of_other_positions_is_refused(tmp_path):
    """Commands and measurements differ by a lag: a model of the one does not fit the other."""
    model = exact_model('ur10e')
    write_model(tmp_path / 'model.yaml', model)
    content = {**model.robot.file.content, 'position': {'source': 'command', 'lag': 0.01}}
    (tmp_path / 'robot.yaml').write_text(yaml.safe_dump(content), encoding='utf-8')
    with pytest.raises(ConfigurationError, match='position.*identify again'):
        build_pipeline(tmp_path / 'model.yaml', 'bayes', robot_path=tmp_path / 'robot.yaml')


def test_e1_2_check_takes_the_lag_off(tmp_path):
    sent, ahead = commanded(exact_model('ur10e'), 30.0)
    robot = with_position(exact_model('ur10e'), source='command', lag=LAG).robot
    told, untold = (next(f.text for f in check_recording(
        recording_of(ahead, arm.joints), arm).findings if f.item == 'delay')
        for arm in (robot, exact_model('ur10e').robot))
    assert 'beyond the lag' in told and 'beyond' not in untold
