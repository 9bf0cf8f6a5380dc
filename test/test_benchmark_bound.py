"""
The Cramer-Rao bound never rises, goes with the noise, and is reached by the best estimate.

Where friction's start is unknown it is what the same rows give with the start's variance among
their noise, never below the other, and near it once joints have slid for long.
"""

from core_helpers import block, exact_model, four_axes, messages
import numpy as np

from hand_load_estimator.benchmark.bound import Bound
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.load import products_jacobian_of_shape
from hand_load_estimator.motion import MotionSample


def bounds(mass=2.0, noise=0.3, seconds=3.0):
    """Return the bound's stds (N, 10) along a motion of a small arm."""
    return both_bounds(mass, noise, np.zeros((int(50 * seconds), 4)))[0]


def both_bounds(mass, noise, left, start_std=2.0):
    """Return the stds (N, 10) of either bound where left (N, 4) is what remains of the start."""
    bound, out = Bound(four_axes(), block(mass), np.full(4, noise), 500.0,
                       np.full(4, start_std)), []
    for sample, share in zip(samples(mass, len(left)), left, strict=True):
        bound.update(sample, share)
        out.append((bound.std(), bound.std_start_unknown()))
    return np.array(out).transpose(1, 0, 2)


def samples(mass, count):
    """Return MotionSamples 20 ms apart of a small arm that rests for 0.6 s and then moves."""
    stream = messages(exact_model('four'), block(mass), count / 50.0, rate=50.0, noisy=False)
    return [MotionSample(m.stamp, 0.02, m.position, m.velocity, np.zeros(4), m.effort,
                         np.zeros(4), False) for m in stream]


def at_rest(robot, q):
    """Return the MotionSample of 0.4 s at rest at q (n,)."""
    still = np.zeros(robot.n)
    return MotionSample(0.0, 0.4, np.asarray(q), still, still, still, still, False)


def fading(count, rest=30):
    """Return (count, 4): 1 while the arm rests, then down to 0 within five samples."""
    return np.clip((rest + 5 - np.arange(count)) / 5.0, 0.0, 1.0)[:, None] * np.ones(4)


def std_of(robot, load, information):
    """Return std (4,) of mass and place from information (10, 10) about the products."""
    shape = load.to_message() / np.r_[1.0, 1.0, 1.0, 1.0, np.full(6, load.mass)]
    jacobian = products_jacobian_of_shape(shape)
    joined = jacobian.T @ information @ jacobian + np.diag(load_prior(robot).std ** -2.0)
    return np.sqrt(np.diag(np.linalg.inv(joined)))[:4]


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
    stream = samples(2.0, 150)
    k = np.array([robot.load_regressor(s.q, s.v, s.a) for s in stream])
    rows = k.reshape(-1, 10)
    bound = Bound(robot, block(2.0), np.full(4, sigma), 50.0, np.ones(4))
    for sample in stream:
        bound.update(sample, np.zeros(4))
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


def test_at_rest_the_start_is_as_good_as_noise_of_the_mean_torque():
    """200 messages at rest: what the mean of a joint's torque tells has the variances of both."""
    robot, load, sigma = four_axes(), block(2.0), 0.3
    start = np.array([1.5, 0.8, 0.6, 0.2])
    bound = Bound(robot, load, np.full(4, sigma), 500.0, start)
    sample = at_rest(robot, [0.3, 0.7, -0.4, 0.9])
    bound.update(sample, np.ones(4))
    k = robot.load_regressor(sample.q, sample.v, sample.a)
    mean = np.full(4, sigma ** 2 / 200.0)
    for found, variance in ((bound.std(), mean), (bound.std_start_unknown(), mean + start ** 2)):
        expected = std_of(robot, load, k.T @ (k / variance[:, None]))
        np.testing.assert_allclose(found[:4], expected, rtol=1e-6)
    assert bound.std_start_unknown()[0] > 3.0 * bound.std()[0]


def test_it_is_least_squares_with_the_starts_covariance_among_the_noise():
    """Along a motion in which friction fades: the same without any nuisance column."""
    robot, sigma, start = four_axes(), 0.3, 2.0
    left, stream = fading(60), samples(2.0, 60)
    information = np.zeros((10, 10))
    for j in range(4):
        k = np.array([robot.load_regressor(s.q, s.v, s.a)[j] for s in stream])
        # Of ten messages a sample.
        noise = sigma ** 2 / 10.0 * np.eye(60) + start ** 2 * np.outer(left[:, j], left[:, j])
        information += k.T @ np.linalg.solve(noise, k)
    _, unknown = both_bounds(2.0, sigma, left, start)
    np.testing.assert_allclose(unknown[-1, :4], std_of(robot, block(2.0), information), rtol=1e-6)


def test_it_is_never_below_the_other_and_near_it_after_long_sliding():
    known, unknown = both_bounds(2.0, 0.3, fading(1500))
    over = unknown / known
    assert (over >= 1.0 - 1e-9).all() and (np.diff(unknown, axis=0) <= 1e-12).all()
    assert over[25, 0] > 3.0
    assert over[-1].max() < 1.05
    assert over[100, 0] > 1.05, 'or it tells nothing of the way there'


def test_a_start_that_is_known_or_left_behind_is_the_other_bound():
    known, unknown = both_bounds(2.0, 0.3, fading(60), start_std=1e-6)
    np.testing.assert_allclose(unknown, known, rtol=1e-6)
    known, unknown = both_bounds(2.0, 0.3, np.zeros((60, 4)))
    np.testing.assert_array_equal(unknown, known)
