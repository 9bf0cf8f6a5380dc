"""A led plant reports what the plant it follows would report without its hidden effects."""

import numpy as np
from plant_helpers import chain, LOAD, ur10e, ur10e_with_effort
import pytest

from hand_load_estimator.plant import Plant
from hand_load_estimator.plant.effects_file import parse_effects
from hand_load_estimator.plant.led_plant import LedPlant
from hand_load_estimator.simulation.simulate_motions import named_motion


def follow(robot, entries, seconds=4.0, name='pick_place', **arguments):
    """Return reported efforts of a plant with effects and of a led one without; q (N, n)."""
    effects = parse_effects(entries, robot)
    motion = named_motion(name, robot, seconds, 1.0, 5)
    arguments = {'seed': 3, 'start_position': motion.position[0], **arguments}
    plant, led = Plant(robot, effects=effects, **arguments), LedPlant(robot, **arguments)
    plant.set_trajectory(robot.joints, motion.time, motion.position, motion.velocity,
                         motion.acceleration)
    rows = []
    for _ in range(int(seconds * plant.rate)):
        rows.append((plant.reported_effort().copy(), led.follow(plant), plant.state()[0]))
        plant.step()
    return [np.array(column) for column in zip(*rows)]


def rms(torque):
    """Return the RMS (n,) of torques (N, n)."""
    return np.sqrt(np.mean(torque ** 2, axis=0))


@pytest.mark.parametrize('robot', [
    ur10e(), chain('z', 'y', 'y', 'x'), ur10e_with_effort(kind='link_torque')],
    ids=['ur10e', 'chain', 'behind the gear'])
def test_without_effects_both_report_the_same(robot):
    reported, led, _ = follow(robot, [], load=LOAD)
    assert (rms(reported - led) < 0.05 * Plant(robot, seed=3).noise).all()


def test_it_differs_by_what_acts_on_the_joint():
    robot = ur10e()
    reported, led, q = follow(robot, [
        {'name': 'gravity_spring', 'joints': ['elbow_joint'],
         'parameters': {'stiffness': 20.0, 'angle': 0.4}}])
    spring = np.zeros_like(q)
    spring[:, 2] = 20.0 * np.sin(q[:, 2] - 0.4)
    assert np.ptp(spring) > 10.0
    assert (rms(reported - led - spring) < 0.05 * Plant(robot, seed=3).noise).all()


@pytest.mark.parametrize('name', ['stribeck_friction', 'presliding_hysteresis', 'backlash',
                                  'load_dependent_friction'])
def test_it_has_the_friction_of_an_arm_without_the_effect(name):
    """Whatever acts on the first joint, its own friction goes on as a clean arm's would."""
    robot = ur10e()
    reported, led, _ = follow(robot, [
        {'name': name, 'joints': ['shoulder_pan_joint'], 'strength': 4.0}], 10.0, 'excite')
    noise = Plant(robot, seed=3).noise
    assert rms(reported - led)[0] > noise[0]
    assert (rms(reported - led)[1:] < 0.05 * noise[1:]).all()
    _, clean, _ = follow(robot, [], 10.0, 'excite')
    # The motion is nearly that of the clean arm, and so is the torque it takes.
    assert np.median(np.abs(led - clean)[:, 0]) < 0.1 * noise[0]


def test_errors_of_the_report_are_not_its_own():
    robot = ur10e()
    reported, led, _ = follow(robot, [
        {'name': 'torque_scale', 'joints': ['shoulder_lift_joint'], 'parameters': {'gain': 0.5}}])
    np.testing.assert_allclose(reported[:, 1], 1.5 * led[:, 1], atol=0.5)
    assert np.abs(reported[:, 1] - led[:, 1]).max() > 10.0
