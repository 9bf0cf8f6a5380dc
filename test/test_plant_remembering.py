"""A plant that tells what is left of its friction's start is that plant, and tells it right."""

from dataclasses import replace

import numpy as np
from plant_helpers import LOAD, sweep, ur10e, ur10e_with_effort

from hand_load_estimator.plant import Plant
from hand_load_estimator.plant.difficulty import DEFAULT
from hand_load_estimator.plant.friction import draw_friction, ELASTIC, Friction
from hand_load_estimator.plant.remembering_plant import RememberingPlant

STEP = 1e-4
RESTS = 50


def led(robot, kind=RememberingPlant, seconds=2.0):
    """
    Return a plant and, at 500 Hz, its state (N, 4, n) and what is left (N, n).

    It rests for 0.1 s and then follows a sweep.
    """
    t, q, v, a = sweep(robot, 10.0)
    plant = kind(robot, start_position=q[0], seed=3, load=LOAD)
    states, left = [], []
    for k in range(int(seconds * plant.rate)):
        if k == RESTS:
            plant.set_trajectory(robot.joints, t, q, v, a)
        plant.step()
        states.append(plant.state())
        left.append(plant.start_left() if kind is RememberingPlant else None)
    return plant, np.array(states), np.array(left)


def test_it_moves_and_measures_as_a_plant_does():
    watched, states, _ = led(ur10e(), seconds=1.0)
    plain, others, _ = led(ur10e(), Plant, seconds=1.0)
    np.testing.assert_array_equal(states, others)
    np.testing.assert_array_equal(watched.measure(), plain.measure())


def test_all_is_left_at_rest_and_nothing_after_a_few_milliradians():
    _, states, left = led(ur10e(), seconds=3.0)
    way = np.abs(states[:, 0] - states[0, 0])
    np.testing.assert_allclose(left[:RESTS], 1.0, atol=1e-3)
    assert (np.abs(left[way > 6e-3]) < 1e-9).all() and (way[-1, :5] > 6e-3).all()
    assert ((left > -1e-9) & (left < 1.0 + 1e-6)).all()


def test_a_shifted_start_follows_the_derivative_of_the_bristles_law():
    """
    Dupont (2002): dz/dx = 1 - w(c) z / level, c: how far z is from elastic to sliding.

    So a difference of two z falls by the derivative of the last term; w: the smooth step.
    """
    drawn = replace(draw_friction(ur10e(), DEFAULT, np.random.default_rng(1)),
                    static=np.zeros(6), asymmetry=np.zeros(6))
    start = Friction(drawn, np.full(6, 25.0), np.zeros(6), np.random.default_rng(4))
    shift = 1e-4 * start.start_std
    beside, still = start.shifted(shift), np.zeros(6)
    level = drawn.coulomb / drawn.stiffness
    z, left, speed, seen = start.torque / drawn.stiffness, np.ones(6), 1e-3, []
    for _ in range(20_000):
        c = np.clip((z / level - ELASTIC) / (1.0 - ELASTIC), 0.0, 1.0)
        w, slope = c * c * (3.0 - 2.0 * c), 6.0 * c * (1.0 - c) / (1.0 - ELASTIC)
        left = left * (1.0 - (w + slope * z / level) / level * speed * STEP)
        z = z + (1.0 - w * z / level) * speed * STEP
        torques = [b.step(np.full(6, speed), still, STEP).copy() for b in (beside, start)]
        seen.append(((torques[0] - torques[1]) / shift, left))
    found, wanted = np.array(seen).transpose(1, 0, 2)
    np.testing.assert_allclose(found, wanted, atol=2e-3)
    assert found[100].min() > 0.0 and found[-1].max() < 0.1


def test_the_start_spreads_as_stated():
    """Even between both levels: a ratio of standard deviation 1 that never passes sqrt(3)."""
    ratio = np.array([plant.friction_torque() / plant.start_std for plant in (
        RememberingPlant(ur10e(), seed=3, run=run) for run in range(60))])
    assert abs(ratio.std() - 1.0) < 0.08 and abs(ratio.mean()) < 0.15
    assert 1.6 < np.abs(ratio).max() <= np.sqrt(3.0)
    level = DEFAULT.coulomb[2] * 0.95 / np.sqrt(3.0)
    cold, warm = (RememberingPlant(ur10e(), seed=3, start_temperature=t) for t in (15.0, 50.0))
    assert 0.8 * level < warm.start_std[0] < cold.start_std[0] < 1.6 * level


def test_a_sensor_behind_the_gear_sees_no_friction():
    plant = RememberingPlant(ur10e_with_effort(kind='link_torque'), seed=3)
    np.testing.assert_array_equal(plant.start_left(), np.zeros(6))
