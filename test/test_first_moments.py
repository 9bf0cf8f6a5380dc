"""Mass, first moment and inertia in place of mass, centre and inertia, and back."""

from core_helpers import four_axes
import numpy as np
import pytest
import torch

from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.learning.first_moments import (message_of, message_prior, moments_of,
                                                        moments_prior)

LOAD = torch.tensor([2.0, 0.03, -0.02, 0.08, 0.02, 0.001, -0.002, 0.03, 0.003, 0.025]).double()
SHARP = torch.full((10,), 1e-5).double()


@pytest.fixture(scope='module')
def prior():
    return load_prior(four_axes())


def test_there_and_back_gives_the_load_where_all_is_known(prior):
    mean, std = message_of(moments_of(LOAD), SHARP, *message_prior(prior))
    np.testing.assert_allclose(mean, LOAD, atol=1e-7)
    np.testing.assert_allclose(std[[0, 4, 9]], SHARP[[0, 4, 9]])
    assert (std[1:4] < 1e-5).all()


def test_a_load_too_light_to_tell_has_the_priors_centre(prior):
    centre, doubt = (part[1:4] for part in message_prior(prior))
    light = LOAD.clone()
    for mass in (1e-3, 0.0, -0.02):
        light[0] = mass
        mean, std = message_of(moments_of(light), torch.full((10,), 0.02).double(),
                               *message_prior(prior))
        np.testing.assert_allclose(mean[1:4], centre, atol=0.005)
        np.testing.assert_allclose(std[1:4], doubt, rtol=0.01)


def test_the_priors_moments_are_those_of_its_draws(prior):
    mean, std = message_prior(prior)
    draws = mean + std * torch.randn(200_000, 10, generator=torch.Generator().manual_seed(1),
                                     dtype=torch.float64)
    moments, spread = moments_prior(prior)
    np.testing.assert_allclose(moments_of(draws).mean(dim=0), moments, atol=0.01 * spread.max())
    np.testing.assert_allclose(moments_of(draws).std(dim=0), spread, rtol=0.01)


@pytest.mark.parametrize('doubt', [(0.05, 0.01), (0.3, 0.02), (0.1, 0.1)])
def test_the_centre_is_what_weighted_draws_of_the_prior_say(prior, doubt):
    """Of loads that the prior holds possible, those whose moments are about what was answered."""
    centre, spread = message_prior(prior)
    generator = torch.Generator().manual_seed(2)
    c = centre[1] + spread[1] * torch.randn(400_000, generator=generator, dtype=torch.float64)
    m = 2.0 + doubt[0] * torch.randn(400_000, generator=generator, dtype=torch.float64)
    h = 2.0 * (centre[1] + 0.5 * spread[1])
    weight = torch.exp(-0.5 * ((h - m * c) / doubt[1]) ** 2)
    weight = weight / weight.sum()
    truth = (weight * c).sum()
    mean, std = LOAD.clone(), SHARP.clone()
    mean[0], mean[1], std[0], std[1] = 2.0, h, *doubt
    told, sure = message_of(mean, std, *message_prior(prior))
    own = torch.sqrt((weight * (c - truth) ** 2).sum())
    assert abs(told[1] - truth) < 0.5 * own and 0.7 < sure[1] / own < 1.8
