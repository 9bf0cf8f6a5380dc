"""What a hand may hold: before any data, and once another load seems to be held."""

import numpy as np
from plant_helpers import ur10e
import pytest

from hand_load_estimator.estimators.load_prior import LIGHT, load_prior


@pytest.fixture
def prior():
    return load_prior(ur10e())


def held(prior, mass):
    """Return the shape (10,) of a load of a mass [kg] that is not where the prior has it."""
    shape = prior.mean + 0.7 * prior.std
    shape[0] = mass
    return shape


def test_after_a_load_another_is_expected_around_it(prior):
    shape = held(prior, 4.0)
    after = prior.after(shape)
    np.testing.assert_allclose(after.mean, shape)
    drawn = prior.mean + prior.std * np.random.default_rng(1).normal(size=(200_000, 10))
    np.testing.assert_allclose(after.std ** 2, ((drawn - shape) ** 2).mean(axis=0), rtol=0.02)


@pytest.mark.parametrize('mass', [0.0, -0.02, -3.0])
def test_after_an_empty_hand_any_load_is_expected(prior, mass):
    after = prior.after(held(prior, mass))
    np.testing.assert_array_equal(after.mean, prior.mean)
    np.testing.assert_array_equal(after.std, prior.std)


def test_the_lighter_a_load_was_the_less_is_expected_around_it(prior):
    masses = np.linspace(0.0, prior.mean[0], 21)
    places = np.array([(prior.after(held(prior, m)).mean - prior.mean)[1] for m in masses])
    full = held(prior, 1.0)[1] - prior.mean[1]
    np.testing.assert_allclose(places, full * np.minimum(masses / (LIGHT * prior.mean[0]), 1.0))
    assert min(prior.after(held(prior, m)).mean[0] for m in masses) >= LIGHT * prior.mean[0]
