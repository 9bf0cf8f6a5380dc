"""Contestants: least squares recursive as in a batch, and ours judged as they are published."""

from core_helpers import block, four_axes
import numpy as np
import pytest

from hand_load_estimator.benchmark.contestants import Contestant
from hand_load_estimator.benchmark.rivals import FixedLoad, LeastSquares
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.identification.identify import nominal_model
from hand_load_estimator.load import (message_from_products, products_from_shape,
                                      products_jacobian_of_shape)
from hand_load_estimator.motion import MotionSample
from hand_load_estimator.torque.model_follower import Prediction


def test_recursive_least_squares_is_the_batch_solution():
    model, rng = nominal_model(four_axes(), np.full(4, 0.02)), np.random.default_rng(2)
    rival, prior = LeastSquares(model, skip_standing=False), load_prior(model.robot)
    variance, load = model.residuals.rmse ** 2, block(2.0).to_products()
    jacobian = products_jacobian_of_shape(prior.mean)
    information = np.linalg.inv(jacobian @ np.diag(prior.std ** 2) @ jacobian.T)
    vector, zero = information @ products_from_shape(prior.mean), np.zeros(4)
    for k in range(40):
        columns = model.robot.load_regressor(*rng.uniform(-1.5, 1.5, (3, 4)))
        torque = columns @ load + np.sqrt(variance) * rng.normal(size=4)
        belief = rival.update(
            MotionSample(0.02 * k, 0.02, zero, zero, zero, zero, zero, False),
            Prediction(torque, columns, np.zeros((4, 0)), zero, zero, zero, zero, zero + 1.0,
                       np.zeros(0)))
        information += (columns / variance[:, None]).T @ columns
        vector += (columns / variance[:, None]).T @ torque
    batch = message_from_products(np.linalg.solve(information, vector))
    np.testing.assert_allclose(belief.mean[:4], batch[:4], atol=1e-6)
    assert np.sqrt(belief.covariance[0, 0]) == pytest.approx(
        np.sqrt(np.linalg.inv(information)[0, 0]), rel=1e-4)


def test_the_careful_rival_leaves_out_what_stands():
    model, zero = nominal_model(four_axes(), np.full(4, 0.02)), np.zeros(4)
    columns = model.robot.load_regressor(np.full(4, 0.4), zero, zero)
    prediction = Prediction(columns @ block(2.0).to_products(), columns, np.zeros((4, 0)), zero,
                            zero, zero, zero, zero + 1.0, np.zeros(0))
    still = MotionSample(0.0, 0.02, zero, zero, zero, zero, zero, False)
    careful, naive = (LeastSquares(model, skip) for skip in (True, False))
    before = careful.belief().mean
    np.testing.assert_array_equal(careful.update(still, prediction).mean, before)
    assert abs(naive.update(still, prediction).mean[0] - before[0]) > 0.01


def test_the_fixed_load_never_learns():
    robot = four_axes()
    belief = FixedLoad(robot).update(None, None)
    np.testing.assert_array_equal(belief.mean, robot.rated_load.to_message())


class Lighter:
    """A method that believes in a little less than nothing."""

    def update(self, sample, prediction):
        return Belief(np.concatenate([[-0.01], np.zeros(9)]), 1e-4 * np.eye(10))


class OurLighter(Lighter):
    tared = np.zeros(10)


def test_ours_are_judged_as_they_are_published_and_rivals_as_they_are():
    ours, rival = (Contestant(None, lambda _, m=m: m()) for m in (OurLighter, Lighter))
    assert ours.update(None).mean[0] >= 0.0 > rival.update(None).mean[0]
