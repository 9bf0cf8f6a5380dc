"""The histogram filter: its lattice finds any peak, its density is that of the data."""

from difference_helpers import model
import numpy as np
import pytest

from hand_load_estimator.estimators.histogram import Histogram
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.estimators.mass_place import MassPlacePosterior
from hand_load_estimator.load import products_from_shape


def normal(mean, covariance):
    """Return the log density of a normal distribution up to a constant."""
    precision = np.linalg.inv(covariance)

    def log_density(candidates):
        away = candidates - mean
        return -0.5 * ((away @ precision) * away).sum(-1)
    return log_density


def refined(histogram, log_density, rounds=30):
    """Refine a histogram for a fixed density until it rests; tell the rounds it took."""
    for count in range(rounds):
        histogram.weigh(log_density(histogram.candidates))
        if not histogram.refine():
            return count
    raise AssertionError('the lattice never rests')


def test_e2_3_four_parameters_at_once_with_steps_of_their_own():
    prior = load_prior(model().robot)
    histogram = Histogram(prior.mean[:4], prior.std[:4], 7)
    assert histogram.candidates.shape == (7 ** 4, 4)
    steps = [np.diff(np.unique(column)).min() for column in histogram.candidates.T]
    assert len(set(np.round(steps, 9))) > 1
    assert histogram.entropy == pytest.approx(4 * np.log(7))


@pytest.mark.parametrize('shrink', [1.0, 0.03, 1e-3])
def test_e2_3_the_peak_is_found_however_narrow_and_askew(shrink):
    """Parameters known together a hundred times better than each alone have a ridge askew."""
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(4, 4)))[0]
    covariance = turn @ np.diag((shrink * np.array([1.0, 0.3, 0.1, 0.03])) ** 2) @ turn.T
    mean = np.array([0.7, -0.4, 0.2, 0.5])
    histogram = Histogram(np.zeros(4), np.ones(4), 7)
    refined(histogram, normal(mean, covariance))
    got, spread = histogram.belief()
    std = np.sqrt(np.diag(covariance))
    assert (np.abs(got - mean) < 0.1 * std).all()
    assert (np.abs(np.sqrt(np.diag(spread)) / std - 1.0) < 0.1).all()
    # The most probable candidate is the one nearest to the mean, within a step.
    assert (np.abs(histogram.best - mean) < 2.0 * std).all()


def test_e2_4_ranges_widen_again_when_the_peak_moves_beyond_the_rim():
    histogram = Histogram(np.zeros(2), np.ones(2), 7)
    refined(histogram, normal(np.zeros(2), 1e-4 * np.eye(2)))
    assert np.abs(histogram.candidates).max() < 0.1
    moved = np.array([1.0, -2.0])
    refined(histogram, normal(moved, 1e-2 * np.eye(2)))
    np.testing.assert_allclose(histogram.mean, moved, atol=0.02)


def test_e6_3_entropy_and_largest_probability_are_the_variance():
    """A normal density's entropy is log det(2 pi e S) / 2: the histogram's leads back to S."""
    for scale in (0.01, 1.0):
        histogram = Histogram(np.zeros(2), np.ones(2), 9)
        covariance = scale * np.array([[2.0, 0.5], [0.5, 1.0]])
        refined(histogram, normal(np.zeros(2), covariance))
        np.testing.assert_allclose(histogram.belief()[1], covariance, rtol=0.1,
                                   atol=0.05 * scale)
    certain = Histogram(np.zeros(2), np.ones(2), 9)
    certain.weigh(normal(np.zeros(2), 1e-6 * np.eye(2))(certain.candidates))
    assert certain.entropy == pytest.approx(0.0) and certain.probabilities.max() > 0.99
    # Within a candidate's cell nothing is known.
    assert 0.1 < np.sqrt(certain.belief()[1][0, 0]) / 0.75 < 0.4


def test_e4_1_the_density_of_candidates_is_that_of_the_data():
    """With the inertia known, the log density is the weighted squared error of the torques."""
    rng = np.random.default_rng(2)
    robot = model().robot
    prior = load_prior(robot)
    k = rng.normal(size=(300, 10))
    truth = products_from_shape(np.concatenate([[2.0, 0.02, -0.01, 0.1], prior.mean[4:]]))
    torque = k @ truth + rng.normal(size=300)
    posterior = MassPlacePosterior(k.T @ k, k.T @ torque, prior, 2.0)
    given = posterior.inertia_given(np.array([2.0, 0.02, -0.01, 0.1]))
    shapes = np.hstack([np.tile([2.0, 0.02, -0.01, 0.1], (50, 1)),
                        prior.mean[4:] + prior.std[4:] * rng.normal(size=(50, 6))])
    error = -0.5 * ((torque - products_from_shape(shapes) @ k.T) ** 2).sum(-1)
    error -= 0.5 * (((shapes - prior.mean) / prior.std)[:, 4:] ** 2).sum(-1)
    own = given.log_density(shapes[:, 4:], list(range(6)), np.zeros(6))
    np.testing.assert_allclose(own - own[0], error - error[0], atol=1e-6)
    assert posterior.log_density(np.array([[-0.1, 0.0, 0.0, 0.1]]))[0] == -np.inf
