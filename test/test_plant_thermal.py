"""Joints warm with work within minutes, cool to the room, and the sensor comes after."""

from hand_load_estimator.plant.difficulty import DEFAULT
from hand_load_estimator.plant.thermal import Thermal
import numpy as np
from plant_helpers import ur10e
import pytest


def thermal(start=25.0, ambient=25.0):
    return Thermal(ur10e(), DEFAULT, start, ambient, np.random.default_rng(0))


def run(joints, power, torque_squared, seconds):
    for _ in range(int(seconds)):
        joints.step(power, torque_squared, 1.0)


def test_work_warms_and_rest_cools_to_the_room():
    joints = thermal()
    power = np.array([15.0, 15.0, 8.0, 3.0, 3.0, 3.0])
    run(joints, power, np.full(6, 100.0), 600)
    warm = joints.gear.copy()
    assert np.all(warm > 30.0) and np.all(warm < 70.0)
    assert np.all(joints.sensor < warm) and np.all(joints.sensor > 26.0)
    run(joints, np.zeros(6), np.zeros(6), 600)
    assert np.all(joints.gear < warm - 2.0)
    run(joints, np.zeros(6), np.zeros(6), 20000)
    np.testing.assert_allclose(joints.gear, 25.0, atol=0.01)


def test_time_constant_is_minutes():
    joints = thermal(start=45.0, ambient=20.0)
    begin = joints.gear - 20.0
    run(joints, np.zeros(6), np.zeros(6), 60)
    assert np.all((joints.gear - 20.0) / begin > 0.8)
    run(joints, np.zeros(6), np.zeros(6), 1200)
    assert np.all((joints.gear - 20.0) / begin < 0.5)


def test_a_second_of_work_in_small_or_large_steps_is_the_same():
    fine, coarse = thermal(), thermal()
    for _ in range(100):
        fine.step(np.full(6, 10.0), np.full(6, 50.0), 0.01)
    coarse.step(np.full(6, 10.0), np.full(6, 50.0), 1.0)
    np.testing.assert_allclose(fine.gear, coarse.gear, atol=1e-2)


def test_start_temperature_has_a_spread_per_joint():
    gear = thermal(start=40.0).gear
    assert np.all(np.abs(gear - 40.0) <= 1.0) and np.ptp(gear) > 0.1
    assert thermal(start=40.0).sensor != pytest.approx(gear, abs=0.1)
    assert thermal(start=25.0).sensor == pytest.approx(thermal(start=25.0).gear, abs=0.3)
