"""Friction sticks, turns over a milliradian or two, slides on its curve, falls when warm."""

from dataclasses import replace

from hand_load_estimator.plant.difficulty import by_size, DEFAULT
from hand_load_estimator.plant.friction import draw_friction, Friction, friction_along
import numpy as np
from plant_helpers import ur10e
import pytest

ROOM = np.full(6, 25.0)
STEP = 1e-3


def figures(seed=0):
    return draw_friction(ur10e(), DEFAULT, np.random.default_rng(seed))


def bristles(friction):
    return Friction(friction, ROOM, np.zeros(6), np.random.default_rng(0))


def slide(friction, speed, steps):
    """Return the torque (steps, 6) of sliding on at one speed."""
    return np.array([friction.step(np.full(6, speed), np.zeros(6), STEP).copy()
                     for _ in range(steps)])


@pytest.mark.parametrize('seed', range(4))
def test_a_reversal_takes_one_to_two_milliradians(seed):
    friction = bristles(replace(figures(seed), asymmetry=np.zeros(6), stribeck_rise=np.zeros(6)))
    slide(friction, -0.005, 3000)
    torque = slide(friction, 0.005, 3000)
    travel = 0.005 * STEP * (1 + np.argmax(torque >= 0.95 * torque[-1], axis=0))
    assert np.all(travel > 0.9e-3) and np.all(travel < 2.2e-3)


def test_presliding_distance_is_what_the_figures_say():
    drawn = figures()
    friction = bristles(drawn)
    slide(friction, -0.002, 6000)
    torque = slide(friction, 0.002, 6000)
    travel = 0.002 * STEP * (1 + np.argmax(torque >= 0.95 * torque[-1], axis=0))
    np.testing.assert_allclose(travel, drawn.presliding, rtol=0.1)


def test_a_small_push_springs_back_and_never_creeps():
    """Near the middle a joint is a spring, however often it is pushed: it does not wander."""
    drawn = figures()
    friction, still = bristles(drawn), np.zeros(6)
    slide(friction, 0.005, 3000)
    while np.max(np.abs(friction.torque)) > 0.05 * np.min(drawn.coulomb):
        friction.step(-np.sign(friction.torque) * 2e-4, still, STEP)
        friction.step(still, still, STEP)
    before = friction.torque.copy()
    for _ in range(300):
        pushed = slide(friction, 1e-3, 50)[-1]
        assert np.all(pushed - before > 0.05 * drawn.coulomb)
        slide(friction, -1e-3, 50)
    np.testing.assert_allclose(friction.step(still, still, STEP), before, atol=1e-9)


def test_sliding_torque_is_the_static_curve():
    """Far from reversals: Coulomb, asymmetry, Stribeck and viscous, in both directions."""
    drawn = figures()
    coulomb, velocity, viscous = drawn.at(ROOM)
    for speed in (0.02, 0.1, 1.0):
        fading = np.exp(-(speed / velocity) ** drawn.stribeck_exponent)
        forwards = slide(bristles(drawn), speed, 2000)[-1]
        backwards = slide(bristles(drawn), -speed, 2000)[-1]
        np.testing.assert_allclose((forwards - backwards) / 2.0,
                                   coulomb + drawn.static * fading + viscous * speed, rtol=1e-6)
        np.testing.assert_allclose((forwards + backwards) / 2.0, drawn.asymmetry, atol=1e-9)


def test_a_reversal_into_the_weak_direction_unloads_like_a_spring():
    """What the bristles hold does not vanish because the other direction would hold less."""
    drawn = replace(figures(), asymmetry=0.8 * figures().coulomb)
    friction, speed = bristles(drawn), 1e-3
    slide(friction, speed, 20_000)
    _, _, viscous = drawn.at(ROOM)
    held = friction.torque - viscous * speed
    back = slide(friction, -speed, 1)[-1] + viscous * speed
    np.testing.assert_allclose(held - back, drawn.stiffness * speed * STEP, rtol=1e-6)


def test_no_speed_makes_it_unstable():
    """A joint that crosses its whole presliding many times in one step stays on the curve."""
    drawn = figures()
    t = np.arange(0.0, 2.0, STEP)
    for peak in (0.5, 3.0, 10.0):
        v = peak * np.sin(2.0 * np.pi * 3.0 * t)[:, None] * np.ones(6)
        torque = friction_along(drawn, v, np.zeros_like(v), ROOM, STEP)
        bound = drawn.coulomb + drawn.static + np.abs(drawn.asymmetry) \
            + drawn.at(ROOM)[2] * np.abs(v)
        assert np.all(np.abs(torque) <= bound + 1e-9)
        assert np.all(torque * v >= -bound * np.abs(v)) and np.ptp(torque) > 1.0


@pytest.mark.parametrize('seed', range(4))
def test_viscous_friction_falls_one_to_two_percent_per_kelvin(seed):
    drawn = figures(seed)
    cold, warm = (drawn.at(np.full(6, t))[2] for t in (24.5, 25.5))
    fall = (cold - warm) / drawn.at(ROOM)[2]
    assert np.all(fall > 0.01) and np.all(fall < 0.02)
    assert np.all(drawn.at(np.full(6, 90.0))[2] > 0.0)


def test_figures_of_the_design_for_the_shipped_robot():
    torque = ur10e().file.max_torque
    np.testing.assert_allclose(by_size(DEFAULT.torque_noise, torque),
                               [1.2, 1.2, 0.9, 0.35, 0.35, 0.35])
    draws = [draw_friction(ur10e(), DEFAULT, np.random.default_rng(s)) for s in range(200)]
    assert np.mean([d.coulomb[0] for d in draws]) == pytest.approx(9.0, rel=0.05)
    assert np.mean([d.at(ROOM)[2][0] for d in draws]) == pytest.approx(12.0, rel=0.05)
    assert 1.8 < np.mean([d.coulomb[5] for d in draws]) < 2.5


def test_other_sizes_lie_between_and_beyond():
    small, between, large = by_size(DEFAULT.coulomb, np.array([10.0, 100.0, 1000.0]))
    assert 0.1 < small < 2.1 < between < 5.0 and 9.0 < large < 40.0
