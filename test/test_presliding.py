"""Presliding: a function of the path, forgotten at rest, honest about what it does not know."""

from itertools import product

from core_helpers import presliding_path
import numpy as np
import pytest

from hand_load_estimator.torque.presliding import (PreslidingState, REST_TIME, stuck_density,
                                                   Turning)

S = 1e-3


def path(q, speed=0.1, dt=0.01):
    """Return z, doubt (N,) of one joint along positions q at a constant stated speed."""
    q = np.asarray(q, dtype=float)[:, None]
    z, doubt = presliding_path(q, np.full_like(q, speed), np.full(len(q), dt), np.array([S]))
    return z[:, 0], doubt[:, 0]


def test_a_long_way_leads_to_the_level_of_its_direction():
    z, doubt = path(np.linspace(0.0, 20 * S, 200))
    assert z[-1] == pytest.approx(1.0, abs=1e-6) and doubt[-1] < 1e-6
    z, _ = path(np.linspace(0.0, -20 * S, 200))
    assert z[-1] == pytest.approx(-1.0, abs=1e-6)


def test_a_reversal_follows_dahls_closed_form():
    there, back = np.linspace(0.0, 20 * S, 100), 20 * S - np.linspace(0.0, 3 * S, 31)
    z, _ = path(np.concatenate([there, back]))
    np.testing.assert_allclose(z[100:], -1.0 + 2.0 * np.exp(-(20 * S - back) / S), atol=1e-6)


@pytest.mark.parametrize('plastic', [0.1, 0.5, 1.2, 2.0])
def test_contacts_are_a_spring_and_then_yield(plastic):
    """Small steps of dz/dq = min(1 - z, p) / s', a reversal less work than at once by 2 s."""
    ways = np.linspace(0.0, 30.0, 300_001)
    z = np.empty_like(ways)
    z[0] = -1.0
    for k, step in enumerate(np.diff(ways)):
        z[k + 1] = z[k] + step * min(1.0 - z[k], plastic)
    ways *= 2.0 * S / np.trapezoid(1.0 - z, ways)
    np.testing.assert_allclose(Turning(plastic).turned(-1.0, ways, S), z, atol=1e-3)


def test_where_contacts_stand_and_which_way_they_went_counts():
    """However far they are from a level; of ways one after the other as of all at once."""
    for plastic in (0.05, 0.5, 1.5):
        turning = Turning(plastic)
        for z, way in product((-1.3, -1.0, -0.2, 0.4, 0.99, 1.0), (-3.0, -0.4, 0.02, 0.7, 4.0)):
            twice = turning.turned(turning.turned(z, 0.3 * way * S, S), 0.7 * way * S, S)
            assert turning.turned(z, way * S, S) == pytest.approx(twice, abs=1e-12)
            assert turning.turned(-z, -way * S, S) == pytest.approx(-twice, abs=1e-12)
        assert turning.turned(0.3, 0.0, S) == 0.3


def test_contacts_that_yield_all_the_way_are_dahls():
    ways = np.linspace(0.0, 5 * S, 20)
    for plastic in (2.0, 3.0, np.inf):
        np.testing.assert_allclose(Turning(plastic).turned(-1.0, ways, S),
                                   1.0 - 2.0 * np.exp(-ways / S), atol=1e-12)


def test_contacts_of_every_kind_are_followed_together():
    rng = np.random.default_rng(3)
    q = np.cumsum(rng.normal(0.0, 4e-4, (200, 1)), axis=0)
    rows = np.repeat(q, 2, axis=1), np.full((200, 2), 0.1), np.full(200, 0.01)
    both, doubt = presliding_path(*rows, np.array([S, S]), np.array([2.0, 0.8]))
    plain, same = presliding_path(*rows, np.array([S, S]))
    np.testing.assert_allclose(both[:, 0], plain[:, 0], atol=1e-12)
    np.testing.assert_array_equal(doubt, same)
    assert np.abs(both[:, 1] - plain[:, 1]).max() > 0.05


def test_the_path_counts_and_not_its_sampling():
    coarse, fine = np.linspace(0.0, 3 * S, 7), np.linspace(0.0, 3 * S, 61)
    assert path(coarse)[0][-1] == pytest.approx(path(fine)[0][-1], abs=1e-9)
    assert path(coarse)[1][-1] == pytest.approx(path(fine)[1][-1], abs=1e-9)


def test_rest_forgets_and_motion_learns():
    q = np.concatenate([np.linspace(0.0, 10 * S, 100), np.full(60, 10 * S),
                        10 * S + np.linspace(0.0, 10 * S, 100)])
    v = np.concatenate([np.full(100, 0.1), np.zeros(60), np.full(100, 0.1)])
    _, doubt = presliding_path(q[:, None], v[:, None], np.full(len(q), 0.01), np.array([S]))
    assert doubt[99, 0] < 1e-3
    rest = doubt[100 + int(REST_TIME / 0.01) + 2:160, 0]
    assert (rest >= 1.0).all() and (np.diff(rest) >= 0.0).all() and rest[-1] < 2.0
    assert doubt[100 + int(REST_TIME / 0.01) - 2, 0] < 1e-3, 'a short stop is no rest'
    assert doubt[-1, 0] < 1e-3


def test_a_long_rest_tells_no_more_than_a_short_one():
    """Information of a constant unknown: the sum of dt / doubt^2 at rest must not grow on."""
    _, doubt = presliding_path(np.zeros((6000, 1)), np.zeros((6000, 1)), np.full(6000, 0.01),
                               np.array([S]))
    assert told_of_friction(doubt[:, 0]) < 1.05 * told_of_friction(doubt[:3000, 0])


def told_of_friction(doubt):
    """Return what a rest sampled every 10 ms tells of friction, over what its bounds tell."""
    density = stuck_density(np.zeros(1), doubt, np.zeros(1), 1.0)
    return np.sum(0.01 / density) / 3.0


@pytest.mark.parametrize('noise', [0.0, 1e-3, 3e-3])
def test_waiting_tells_no_more_than_that_friction_lies_between_its_levels(noise):
    """Uniform between two levels is a variance of a third; noise of the speed is no motion."""
    rng, v = np.random.default_rng(2), np.zeros((6000, 1))
    _, doubt = presliding_path(rng.uniform(-1e-5, 1e-5, v.shape), noise * rng.normal(size=v.shape),
                               np.full(len(v), 0.01), np.array([S]))
    assert told_of_friction(doubt[:, 0]) < 0.85


def test_joints_are_followed_apart():
    state = PreslidingState(np.array([S, S, 5 * S]), np.full(3, np.inf))
    for k in range(50):
        z, doubt = state.update(np.array([0.0, 1.0, -1.0]) * k * S / 5,
                                np.array([0.0, 0.1, -0.1]), 0.01)
    assert z[0] == 0.0 and z[1] > 0.99 and -0.95 < z[2] < -0.8
    assert doubt[0] >= 1.0 and doubt[1] < 0.01


def test_a_sliding_joint_tells_all_and_a_held_one_little():
    level = np.array([9.0])
    zero, one, fast = np.zeros(1), np.ones(1), np.array([0.5])
    sliding = stuck_density(one, zero, fast, level)
    turning = stuck_density(zero, zero, fast, level)
    held = stuck_density(zero, one, zero, level)
    assert 0.0 <= sliding < 1e-6 < turning < held
    # Held, it may be anywhere: density 2 level^2 time of at least a quarter of the level.
    assert held > 2.0 * (0.25 * level) ** 2
    assert stuck_density(zero, one, zero, 2 * level) \
        == pytest.approx(4.0 * held)


def test_a_level_that_rounding_passed_has_no_variance_below_zero():
    """A filter of level 1 may be a unit in the last place above it; a root of that is NaN."""
    z = np.array([1.0 + 2e-16, -1.0 - 2e-16, 1.0])
    assert (stuck_density(z, np.zeros(3), np.full(3, 10.0), 1.0) >= 0.0).all()
