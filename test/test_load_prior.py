"""What a hand may hold: before any data, and once another load seems to be held."""

import numpy as np
from plant_helpers import ur10e
import pytest

from hand_load_estimator.estimators.load_prior import load_prior


@pytest.fixture
def prior():
    return load_prior(ur10e())


def held(prior, mass):
    """Return the shape (10,) of a load of a mass [kg] that is not where the prior has it."""
    shape = prior.mean + 0.7 * prior.std
    shape[0] = mass
    return shape


def test_after_a_load_that_was_known_another_is_expected_around_it(prior):
    shape = held(prior, 2.0)
    after = prior.after(shape, np.zeros(10))
    np.testing.assert_allclose(after.mean, shape)
    drawn = prior.mean + prior.std * np.random.default_rng(1).normal(size=(200_000, 10))
    np.testing.assert_allclose(after.std ** 2, ((drawn - shape) ** 2).mean(axis=0), rtol=0.02)


def test_where_nothing_was_found_nothing_else_is_expected(prior):
    after = prior.after(prior.mean, prior.std ** 2)
    np.testing.assert_array_equal(after.mean, prior.mean)
    np.testing.assert_array_equal(after.std, prior.std)


@pytest.mark.parametrize('mass, place', [(0.01, 1.0), (-0.02, 0.0)])
def test_after_an_empty_hand_any_load_is_expected(prior, mass, place):
    """A load of no mass, or of no place, however well its mass was known."""
    variance = place * prior.std ** 2
    variance[0] = 1e-6
    after = prior.after(held(prior, mass), variance)
    assert after.mean[0] == prior.mean[0] and after.std[0] == prior.std[0]
