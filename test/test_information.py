"""The recursive regression against the batch solution (eq. 13, 14), and its honesty."""

from dataclasses import replace

from core_helpers import block, exact_model
import numpy as np
from plant_helpers import ur10e
import pytest

from hand_load_estimator.estimators.bayes import Bayes
from hand_load_estimator.estimators.information import (Information, message_covariance,
                                                        posterior_of, shape_posterior)
from hand_load_estimator.estimators.load_prior import load_prior, LoadPrior
from hand_load_estimator.load import (message_from_shape, products_from_shape,
                                      products_jacobian_of_shape)
from hand_load_estimator.motion import MotionSample
from hand_load_estimator.torque.model_follower import Prediction

ROBOT = ur10e()
SIGMA = 0.3  # [Nm]


def rows(rng, count, nuisances=0, size=1.0):
    """Return columns (count, n, 10 + r) at random motions."""
    n = ROBOT.n
    q, v, a = rng.uniform(-2.0, 2.0, (3, count, n))
    load = np.array([ROBOT.load_regressor(*row) for row in zip(q, v, a)])
    return np.concatenate([load, size * rng.normal(size=(count, n, nuisances))], axis=2)


def information_of(columns, torque, weights=None):
    out = Information(ROBOT.n, columns.shape[2] - 10)
    weights = np.full(columns.shape[:2], SIGMA ** -2.0) if weights is None else weights
    for k in range(len(columns)):
        out.add_rows(columns[k], torque[k], weights[k])
    return out


def flat_prior():
    """Return a prior too wide to matter where data are good."""
    prior = load_prior(ROBOT)
    return LoadPrior(prior.mean, 1e3 * prior.std)


def posterior(information, prior=None, start=None, steps=4, **options):
    """Return the posterior after as many calls as let Gauss-Newton arrive."""
    prior = prior or load_prior(ROBOT)
    start = prior.mean if start is None else start
    for _ in range(steps):
        out = posterior_of(information, prior, start, **options)
        start = out.shape
    return out


def test_e7_2_products_are_the_batch_solution_of_weighted_least_squares():
    rng, load = np.random.default_rng(1), block(6.0)
    columns = rows(rng, 200)
    weights = rng.uniform(0.2, 5.0, columns.shape[:2])
    torque = columns @ load.to_products() + rng.normal(size=weights.shape) / np.sqrt(weights)
    got = posterior(information_of(columns, torque, weights), flat_prior())
    a = (columns * np.sqrt(weights)[:, :, None]).reshape(-1, 10)
    covariance = np.linalg.inv(a.T @ a)
    batch = covariance @ a.T @ (torque * np.sqrt(weights)).ravel()
    std = np.sqrt(np.diag(covariance))
    assert (np.abs(got.products - batch) < 1e-3 * std).all()
    np.testing.assert_allclose(got.products_covariance / np.outer(std, std),
                               covariance / np.outer(std, std), atol=1e-4)


def test_e7_3_the_prior_counts_as_data_of_its_own():
    """Where the problem is linear (mass known) prior and data join as two normals do."""
    rng = np.random.default_rng(2)
    shape = np.array([5.0, 0.02, -0.03, 0.1, 0.006, 1e-3, -8e-4, 0.008, 5e-4, 0.005])
    # Not known better: of a standard deviation of 1e-9 kg, rounding of 5 kg is 1e-6.
    prior = LoadPrior(shape, np.array([1e-8, *[0.02] * 3, *[2e-3] * 6]))
    truth = shape + prior.std * rng.normal(size=10)
    columns = rows(rng, 6)
    torque = columns @ products_from_shape(truth) + SIGMA * rng.normal(size=columns.shape[:2])
    got = posterior(information_of(columns, torque), prior, steps=12)
    jacobian = products_jacobian_of_shape(got.shape)
    a = (columns @ jacobian).reshape(-1, 10) / SIGMA
    rest = (torque - columns @ (products_from_shape(got.shape) - jacobian @ got.shape)
            ).ravel() / SIGMA
    precision = np.diag(prior.std ** -2.0)
    covariance = np.linalg.inv(a.T @ a + precision)
    np.testing.assert_allclose((got.shape - covariance @ (a.T @ rest + precision @ prior.mean))
                               / prior.std, 0.0, atol=1e-6)
    np.testing.assert_allclose(got.shape_covariance / np.outer(prior.std, prior.std),
                               covariance / np.outer(prior.std, prior.std), atol=1e-6)


def test_nuisances_are_marginalised_as_the_joint_solution_does():
    rng, load = np.random.default_rng(3), block(4.0)
    columns = rows(rng, 100, nuisances=7, size=2.0)
    nuisance = rng.normal(size=7)
    torque = columns @ np.concatenate([load.to_products(), nuisance]) \
        + SIGMA * rng.normal(size=columns.shape[:2])
    information = information_of(columns, torque)
    matrix, vector = information.load_share()
    a = columns.reshape(-1, 17) / SIGMA
    joint = a.T @ a + np.diag([0.0] * 10 + [1.0] * 7)
    covariance = np.linalg.inv(joint)
    solution = covariance @ a.T @ torque.ravel() / SIGMA
    np.testing.assert_allclose(np.linalg.inv(matrix), covariance[:10, :10], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(np.linalg.solve(matrix, vector), solution[:10], atol=1e-6)
    np.testing.assert_allclose(information.nuisance_given(solution[:10]), solution[10:],
                               atol=1e-6)


def test_order_of_samples_and_pieces_does_not_matter():
    rng = np.random.default_rng(4)
    columns, torque = rows(rng, 60, nuisances=3), rng.normal(size=(60, 6))
    order = rng.permutation(60)
    whole = information_of(columns, torque)
    mixed = information_of(columns[order], torque[order])
    halves = information_of(columns[:20], torque[:20])
    halves.add(information_of(columns[20:], torque[20:]))
    for other in (mixed, halves):
        for name in ('matrix', 'vector', 'by_joint'):
            np.testing.assert_allclose(getattr(other, name), getattr(whole, name), rtol=1e-9,
                                       atol=1e-9)
    np.testing.assert_allclose(posterior(mixed).mean, posterior(whole).mean, atol=1e-9)


def test_without_data_the_posterior_is_the_prior():
    prior = load_prior(ROBOT)
    got = posterior_of(Information(6, 4), prior, prior.mean)
    np.testing.assert_allclose(got.shape, prior.mean, atol=1e-12)
    np.testing.assert_allclose(np.sqrt(np.diag(got.shape_covariance)), prior.std, rtol=1e-9)
    np.testing.assert_allclose(got.mean, message_from_shape(prior.mean), atol=1e-12)


def test_inertias_variance_is_that_of_a_product():
    """Var(m g) of two independent unknowns, against drawing them."""
    rng, shape = np.random.default_rng(5), load_prior(ROBOT).mean
    std = load_prior(ROBOT).std
    draws = message_from_shape(shape + std * rng.normal(size=(200000, 10)))
    got = np.sqrt(np.diag(message_covariance(shape, np.diag(std ** 2))))
    np.testing.assert_allclose(got, draws.std(axis=0), rtol=0.02)


def gain_problem(mass, offset):
    """Return columns and noise-free torques of a load; offset [Nm]: what each joint's may be."""
    columns = rows(np.random.default_rng(6), 150)
    torque = columns @ block(mass).to_products()
    offsets = np.tile(offset * np.eye(6), (150, 1, 1))
    return (np.concatenate([columns, offsets], axis=2) if offset else columns), torque


@pytest.mark.parametrize('offset', [0.0, 10.0])
def test_doubt_of_a_torque_constant_is_what_a_wrong_one_does(offset):
    """Std by gain doubt against shifting one joint's gain after the other by one percent."""
    columns, torque = gain_problem(5.0, offset)
    exact = posterior(information_of(columns, torque), flat_prior())
    moves = []
    for j in range(6):
        wrong = torque.copy()
        wrong[:, j] *= 1.01
        moved = posterior(information_of(columns, wrong), flat_prior(), exact.shape)
        moves.append((moved.shape - exact.shape) / 0.01)
    doubted = posterior(information_of(columns, torque), flat_prior(), gain_doubt=0.05)
    extra = np.diag(doubted.shape_covariance - exact.shape_covariance)
    expected = 0.05 * np.sqrt(np.sum(np.square(moves), axis=0))
    np.testing.assert_allclose(np.sqrt(extra[:4]), expected[:4], rtol=0.1)


def test_doubt_of_the_torque_constants_is_a_share_of_the_mass():
    stds = []
    for mass in (2.0, 4.0, 8.0):
        got = posterior(information_of(*gain_problem(mass, 0.0)), flat_prior(), gain_doubt=0.05)
        stds.append(np.sqrt(got.covariance[0, 0]))
    np.testing.assert_allclose(np.array(stds) / stds[0], [1.0, 2.0, 4.0], rtol=0.02)
    assert 0.05 * 2.0 / np.sqrt(6) * 0.9 < stds[0] <= 0.05 * 2.0 * 1.01


def test_what_was_tared_stays_in_doubt():
    rng, tare = np.random.default_rng(7), np.diag(np.linspace(0.1, 0.4, 10) ** 2 * 0.01)
    columns = rows(rng, 300)
    torque = columns @ block(5.0).to_products()
    information = information_of(columns, torque)
    got = posterior(information, flat_prior(), tare=tare)
    plain = posterior(information, flat_prior())
    np.testing.assert_allclose(got.products, plain.products, atol=1e-4)
    np.testing.assert_allclose(got.products_covariance, plain.products_covariance + tare,
                               rtol=1e-3, atol=1e-6)


def test_a_few_steps_from_the_last_solution_arrive():
    rng = np.random.default_rng(8)
    columns = rows(rng, 100)
    torque = columns @ block(9.0).to_products() + SIGMA * rng.normal(size=(100, 6))
    prior = load_prior(ROBOT)
    half = posterior(information_of(columns[:50], torque[:50])).shape
    whole = information_of(columns, torque).load_share()
    shape, covariance = shape_posterior(*whole, prior, half)
    best = shape
    for _ in range(20):
        best, _ = shape_posterior(*whole, prior, best)
    assert (np.abs(shape - best) < 1e-3 * np.sqrt(np.diag(covariance))).all()


def test_bayes_covers_the_truth_as_often_as_it_says():
    """
    Draw loads from the prior and see whether 95 % means 95 %.

    Forty arms with five loads each: the five share the arm's nuisances, as cases of a plant do.
    """
    model, rng = exact_model('ur10e'), np.random.default_rng(9)
    prior, inside = load_prior(ROBOT), []
    dt, count, r, density = 0.02, 25, 8, 0.05
    # The residual a model states is of data left out: what it may be wrong by is in there.
    doubt = (rows(rng, 1000, r, size=1.5)[:, :, 10:] ** 2).sum(axis=2).mean()
    model = replace(model, residuals=replace(
        model.residuals, rmse=np.full(6, np.sqrt(density / dt + doubt))))
    for _ in range(40):
        nuisance = rng.normal(size=r)
        for _ in range(5):
            shape = prior.mean + prior.std * rng.normal(size=10)
            while shape[0] < 0.3:
                shape = prior.mean + prior.std * rng.normal(size=10)
            truth = np.concatenate([products_from_shape(shape), nuisance])
            method = Bayes(model, r)
            columns = rows(rng, count, r, size=1.5)
            torque = columns @ truth + np.sqrt(density / dt) * rng.normal(size=(count, 6))
            for k in range(count):
                zero = np.zeros(6)
                sample = MotionSample(k * dt, dt, zero, zero + 0.5, zero, zero, zero, False)
                belief = method.update(sample, Prediction(
                    torque[k], columns[k, :, :10], columns[k, :, 10:], zero, zero, zero, zero,
                    np.full(6, density), np.ones(columns.shape[2] - 10)))
            error = belief.mean - message_from_shape(shape)
            inside.append(np.abs(error) <= 1.96 * np.sqrt(np.diag(belief.covariance)))
            assert method.changes == 0
    coverage = np.array(inside).mean(axis=0)
    assert len(inside) == 200 and (coverage >= 0.90).all() and (coverage <= 0.99).all(), coverage
