"""What is published is a load that can exist, and what the data determine hardly moves."""

from dataclasses import replace

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
import pytest
from test_load import random_load

from hand_load_estimator.estimators import physical_consistency
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.estimators.physical_consistency import LIGHTEST, physically_consistent
from hand_load_estimator.load import (inertia_of_second_moments, LoadParameters,
                                      products_from_message, pseudo_inertia, second_moments)

SCALE = np.array([2.0, 0.1, 0.1, 0.1, 0.1, 0.05, 0.05, 0.1, 0.05, 0.1])


def random_covariance(rng, orders=1.5):
    """Return a covariance (10, 10) with deviations over orders of magnitude, correlated."""
    std = SCALE * 10.0 ** rng.uniform(-orders, 0.3, 10)
    mixed = rng.normal(size=(10, 20))
    mixed /= np.linalg.norm(mixed, axis=1)[:, None]
    return std[:, None] * (mixed @ mixed.T) * std


def distance(belief, load):
    """Return how far the inertia of a load (10,) is from a belief's, in its deviations."""
    off = (belief.mean - load)[4:]
    return float(np.sqrt(off @ np.linalg.solve(belief.covariance[4:, 4:], off)))


def noisy_beliefs(seed, count):
    """Yield (true load (10,), Belief as far off as its covariance says)."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        load = random_load(rng, lightest=0.01).to_message()
        covariance = random_covariance(rng)
        yield load, Belief(rng.multivariate_normal(load, covariance), covariance)


def positive_definite(mean):
    return np.linalg.eigvalsh(pseudo_inertia(products_from_message(mean)))[0] > 0.0


def test_what_comes_out_is_possible_and_nearer_to_the_truth():
    """A step to a half space brings the mean nearer to each point of the half space."""
    changed = 0
    for load, belief in noisy_beliefs(1, 1000):
        out = physically_consistent(belief)
        if out is belief:
            continue
        changed += 1
        assert LoadParameters.from_message(out.mean).is_physical()
        assert positive_definite(out.mean) and out.covariance is belief.covariance
        np.testing.assert_array_equal(out.mean[1:4], belief.mean[1:4])
        assert out.mean[0] == max(belief.mean[0], LIGHTEST)
        if LIGHTEST < belief.mean[0] < load[0]:
            assert distance(out, load) <= distance(belief, load) + 1e-6
    assert changed > 500


def test_what_is_possible_stays_as_it_is():
    for load, belief in noisy_beliefs(2, 200):
        possible = Belief(load, belief.covariance)
        assert physically_consistent(possible) is possible
        once = physically_consistent(belief)
        assert physically_consistent(once) is once


def test_only_a_contradiction_is_left_as_it_is():
    """Beyond three deviations the controller falls back (negative_mass): nobody may hide it."""
    covariance = np.diag((0.02 * SCALE) ** 2)
    load = block(0.0).to_message()
    for below, left in ((2.9, False), (3.1, True)):
        load[0] = -below * 0.02 * SCALE[0]
        out = physically_consistent(Belief(load, covariance))
        assert (out.mean[0] < 0.0) == left
    still = [b for _, b in noisy_beliefs(3, 1000)
             if not LoadParameters.from_message(physically_consistent(b).mean).is_physical()]
    for belief in still:
        moments = np.linalg.eigvalsh(second_moments(belief.mean[4:]))
        assert belief.mean[0] < 0.0 or moments[0] < 0.0
    assert len(still) < 10


def test_a_mean_too_hard_for_the_steps_is_possible_all_the_same(monkeypatch):
    monkeypatch.setattr(physical_consistency, 'STEPS', 1)
    for _, belief in noisy_beliefs(5, 300):
        out = physically_consistent(belief)
        assert out is belief or positive_definite(out.mean)


def test_determined_moments_hardly_move():
    """A wide thin plate: two moments are known well, the third is near zero and is not."""
    rng, moved = np.random.default_rng(4), []
    for _ in range(300):
        moments = np.array([4e-2, 3e-2, 1e-5])
        std = np.concatenate([[2e-3, 1e-3, 1e-3, 1e-3], np.full(6, 5e-3)])
        # Known: int x x dm and int y y dm. Not known: int z z dm, and the products.
        to_inertia = np.array([inertia_of_second_moments(np.diag(e)) for e in np.eye(3)]).T
        spread = to_inertia @ np.diag([1e-4, 1e-4, 5e-3])
        covariance = np.diag(std ** 2)
        covariance[4:, 4:] = spread @ spread.T + np.diag([0, 1, 1, 0, 1, 0]) * 1e-4 ** 2
        load = np.concatenate([[4.0, 0.0, 0.1, 0.1], to_inertia @ moments])
        belief = Belief(rng.multivariate_normal(load, covariance), covariance)
        out = physically_consistent(belief)
        if out is not belief:
            before, after = (np.diag(second_moments(b.mean[4:])) for b in (belief, out))
            moved.append(np.abs(after - before) / [1e-4, 1e-4, 5e-3])
    assert len(moved) > 100
    assert np.max(moved, axis=0)[:2].max() < 0.1 < np.median(moved, axis=0)[2]


def test_an_empty_hand_weighs_nothing_and_after_tare_less_is_less():
    model = exact_model('four')
    empty, tared = warm(pipeline_of(model)), warm(pipeline_of(model))
    masses = [e.mean[0] for e in feed(empty, messages(model, LoadParameters(), 3.0))]
    assert min(masses) > 0.0
    feed(tared, messages(model, block(1.5), 5.0))
    tared.tare(tared.last_stamp)
    lighter = feed(tared, [replace(m, stamp=m.stamp + 5.5)
                           for m in messages(model, block(1.0), 4.0, seed=1)])
    assert lighter[-1].mean[0] == pytest.approx(-0.5, abs=0.1)
