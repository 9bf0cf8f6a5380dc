"""A led plant tells the torque of the motion that it is led along, with and without effects."""

import numpy as np
from plant_helpers import chain, LOAD, ur10e
import pytest

from hand_load_estimator.plant import Plant
from hand_load_estimator.plant.effects_file import parse_effects
from hand_load_estimator.plant.led_plant import LedPlant
from hand_load_estimator.simulate_motions import named_motion


def follow(robot, entries, seconds=4.0, name='pick_place', **arguments):
    """Return torques (N, n) of a plant with effects and of led ones, with and without; q (N, n)."""
    effects = parse_effects(entries, robot)
    motion = named_motion(name, robot, seconds, 1.0, 5)
    arguments = {'seed': 3, 'start_position': motion.position[0], **arguments}
    plant = Plant(robot, effects=effects, **arguments)
    led = [LedPlant(robot, effects=e, **arguments) for e in (effects, ())]
    plant.set_trajectory(robot.joints, motion.time, motion.position, motion.velocity,
                         motion.acceleration)
    rows = []
    for _ in range(int(seconds * plant.rate)):
        q, v, _, torque = plant.state()
        rows.append((torque, *(one.follow(plant, q, v) for one in led), q))
        plant.step()
    return [np.array(column) for column in zip(*rows)]


def rms(torque):
    """Return the RMS (n,) of torques (N, n)."""
    return np.sqrt(np.mean(torque ** 2, axis=0))


@pytest.mark.parametrize('robot', [ur10e(), chain('z', 'y', 'y', 'x')], ids=['ur10e', 'chain'])
def test_without_effects_it_is_the_torque_of_the_drives(robot):
    torque, led, _, _ = follow(robot, [], load=LOAD)
    assert (rms(torque - led) < 0.1 * Plant(robot, seed=3).noise).all()


@pytest.mark.parametrize('name, share', [
    ('torque_ripple', 0.02), ('stribeck_friction', 0.05), ('presliding_hysteresis', 0.02),
    ('load_dependent_friction', 0.02)])
def test_an_effect_costs_it_what_it_costs_the_plant(name, share):
    robot = ur10e()
    torque, led, without, _ = follow(robot, [
        {'name': name, 'joints': ['shoulder_pan_joint'], 'strength': 4.0}], 10.0, 'excite')
    effect = rms(torque - without)
    noise = Plant(robot, seed=3).noise
    assert effect[0] > noise[0]
    assert rms(torque - led)[0] < share * effect[0]
    assert (rms(torque - led)[1:] < 0.1 * noise[1:]).all()


def test_teeth_meet_as_the_plant_s_do_in_the_same_steps():
    torque, led, without, _ = follow(ur10e(), [
        {'name': 'backlash', 'joints': ['shoulder_pan_joint'], 'strength': 4.0}],
        10.0, 'excite', rate=1000.0)
    assert rms(torque - without)[0] > 5.0
    assert rms(torque - led)[0] < 1e-3


def test_a_spring_is_all_that_two_of_them_differ_by():
    robot = ur10e()
    _, led, without, q = follow(robot, [
        {'name': 'gravity_spring', 'joints': ['elbow_joint'],
         'parameters': {'stiffness': 20.0, 'angle': 0.4}}])
    spring = np.zeros_like(q)
    spring[:, 2] = 20.0 * np.sin(q[:, 2] - 0.4)
    assert np.ptp(spring) > 10.0
    np.testing.assert_allclose(led - without, spring, atol=1e-9)


def test_what_is_held_for_a_time_is_in_its_torque():
    robot = ur10e()
    torque, led, without, _ = follow(robot, [
        {'name': 'load_change', 'parameters': {
            'mass': 3.0, 'com': [0.0, 0.0, 0.1], 'start': 1.0, 'duration': 2.0}}])
    held = slice(510, 1490)
    assert rms((torque - without)[held])[1] > 5.0
    assert (rms(torque - led) < 0.2 * Plant(robot, seed=3).noise).all()
