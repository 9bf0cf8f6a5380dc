"""The Cramer-Rao bound never rises, goes with the noise, and is reached by the best estimate."""

from core_helpers import block, exact_model, four_axes, messages
import numpy as np

from hand_load_estimator.benchmark.bound import Bound
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.load import products_jacobian_of_shape
from hand_load_estimator.motion import MotionSample


def bounds(mass=2.0, noise=0.3, seconds=3.0):
    """Return the bound's stds (N, 10) along a motion of a small arm."""
    robot = four_axes()
    bound, out = Bound(robot, block(mass), np.full(4, noise), 500.0), []
    for m in messages(exact_model('four'), block(mass), seconds, rate=50.0, noisy=False):
        bound.update(MotionSample(m.stamp, 0.02, m.position, m.velocity, np.zeros(4), m.effort,
                                  np.zeros(4), False))
        out.append(bound.std())
    return np.array(out)


def test_the_bound_never_rises_and_begins_below_the_prior():
    stds = bounds()
    assert (np.diff(stds, axis=0) <= 1e-12).all()
    assert (stds[0, :4] <= load_prior(four_axes()).std[:4] * (1 + 1e-9)).all()
    assert (stds[-1, :4] < 0.2 * stds[0, :4]).all()


def test_the_bound_is_in_proportion_to_the_noise_once_data_rule():
    few, many = bounds(noise=0.01)[-1], bounds(noise=0.02)[-1]
    np.testing.assert_allclose(many[:4] / few[:4], 2.0, rtol=0.02)


def test_the_bound_is_the_spread_of_the_best_estimate():
    """Least squares with exact model and noise cannot do better, and does as well."""
    robot, rng, sigma = four_axes(), np.random.default_rng(1), 0.05
    stream = messages(exact_model('four'), block(2.0), 3.0, rate=50.0, noisy=False)
    k = np.array([robot.load_regressor(m.position, m.velocity, np.zeros(4)) for m in stream])
    rows = k.reshape(-1, 10)
    bound = Bound(robot, block(2.0), np.full(4, sigma), 50.0)
    for m in stream:
        bound.update(MotionSample(m.stamp, 0.02, m.position, m.velocity, np.zeros(4), m.effort,
                                  np.zeros(4), False))
    shape = block(2.0).to_message() / np.r_[1.0, 1.0, 1.0, 1.0, np.full(6, 2.0)]
    jacobian = products_jacobian_of_shape(shape)
    precision = np.diag(load_prior(robot).std ** -2.0)
    a = rows @ jacobian / sigma
    gain = np.linalg.inv(a.T @ a + precision)
    errors = []
    for _ in range(400):
        prior = load_prior(robot).std * rng.normal(size=10)
        noise = rng.normal(size=len(rows))
        errors.append(gain @ (a.T @ noise + precision @ prior))
    spread = np.std(errors, axis=0)
    np.testing.assert_allclose(bound.std()[:4], spread[:4], rtol=0.15)
