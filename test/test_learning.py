"""What training is made of: sequences, the regression as a layer, the objective, calibration."""

from core_helpers import block, exact_model, four_axes
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm
import torch

from hand_load_estimator.estimators.information import Information, posterior_of
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.learning import calibration, random_loads
from hand_load_estimator.learning.calibration import calibrate, held_out_scores, TOLD
from hand_load_estimator.learning.features import feature_count, features, INPUTS
from hand_load_estimator.learning.interval_factors import LEVELS
from hand_load_estimator.learning.network import LoadNetwork
from hand_load_estimator.learning.objective import (answers, divergence, DIVERGENCES,
                                                    jensen_shannon, JUDGED, LABEL_STD)
from hand_load_estimator.learning.random_loads import random_load, SHAPES
from hand_load_estimator.learning.random_motions import random_motion, random_moves, random_waves
from hand_load_estimator.learning.regression_layer import (chunk_sums, marginal, message_moments,
                                                           products_of_shape, shape_posterior)
from hand_load_estimator.learning.sequences import (_vary, DURATION, EVERY, OVERSTATED, RATE,
                                                    SequenceMaker)
from hand_load_estimator.learning.shards import make_shard, prior_tensors
from hand_load_estimator.learning.unmodelled import (coloured_noise, draw_friction,
                                                     friction_state, friction_torque)
from hand_load_estimator.load import (products_from_shape, products_jacobian_of_shape,
                                      pseudo_inertia)

SIZE = 5
STEPS = int(DURATION * RATE) // EVERY


@pytest.fixture(scope='module')
def model():
    return exact_model('four', doubt=0.02)


@pytest.fixture(scope='module')
def shard(model):
    return make_shard(SequenceMaker(model), model.robot, range(4))


def test_the_layers_products_and_jacobian_are_those_of_load():
    rng = np.random.default_rng(1)
    shape = np.concatenate([rng.uniform(0.5, 5, (6, 1)), rng.normal(0, 0.1, (6, 9))], axis=1)
    products, jacobian = products_of_shape(torch.tensor(shape))
    np.testing.assert_allclose(products, products_from_shape(shape), atol=1e-14)
    np.testing.assert_allclose(jacobian, products_jacobian_of_shape(shape), atol=1e-14)


def test_the_layer_is_the_recursive_regression():
    robot, rng = four_axes(), np.random.default_rng(2)
    prior, n, r, steps = load_prior(robot), 4, 6, 60
    columns = np.empty((steps, n, 10 + r))
    for row in columns:
        row[:, :10] = robot.load_regressor(*rng.uniform(-1.5, 1.5, (3, n)))
        row[:, 10:] = rng.normal(size=(n, r))
    difference = columns[:, :, :10] @ block(3.0).to_products() + rng.normal(size=(steps, n))
    weights = rng.uniform(0.1, 3.0, (steps, n))
    matrix, vector = chunk_sums(torch.tensor(columns)[None], torch.tensor(difference)[None],
                                torch.tensor(weights)[None], SIZE)
    shape, covariance = shape_posterior(*marginal(matrix, vector), *map(
        torch.tensor, (prior.mean, prior.std)))
    mean, variance = (x.numpy() for x in message_moments(shape, covariance))
    information, start = Information(n, r), prior.mean
    for k in range(steps):
        information.add_rows(columns[k], difference[k], weights[k])
        if k % SIZE == SIZE - 1:
            for _ in range(4):
                posterior = posterior_of(information, prior, start)
                start = posterior.shape
            std = np.sqrt(np.diag(posterior.covariance))
            chunk = k // SIZE
            np.testing.assert_allclose((mean[0, chunk] - posterior.mean) / std, 0.0, atol=2e-3)
            np.testing.assert_allclose(np.sqrt(variance[0, chunk]), std, rtol=2e-3)


@pytest.mark.parametrize('kind, least', [('kl', 0.05), ('jensen_shannon', 1e-3)])
def test_training_steps_lower_the_objective_through_the_regression(model, shard, kind, least):
    """Gradients reach corrections, which act only through the regression."""
    prior = prior_tensors(model.robot)
    torch.manual_seed(1)
    network = LoadNetwork(feature_count(4), 4, 12)
    # Shift and spread stay as they are: what is learnt here goes through the regression.
    optimiser = torch.optim.Adam([*network.lstm.parameters(),
                                  *network.joint_head.parameters()], lr=1e-2)
    losses = []
    for _ in range(20):
        loss = divergence(*answers(network, shard, *prior)[:2], shard['load'], kind).mean()
        optimiser.zero_grad()
        loss.backward()
        if not losses:
            assert (network.load_head.bias.grad.abs() > 1e-4 * least).all(), 'shift and spread'
        optimiser.step()
        losses.append(loss.item())
    assert losses[-1] < losses[0] - least


def test_a_new_network_does_nothing(model, shard):
    prior = prior_tensors(model.robot)
    with torch.no_grad():
        ours = answers(LoadNetwork(feature_count(4), 4, 6), shard, *prior)
        plain = answers(None, shard, *prior)
    for one, other in zip(ours, plain):
        np.testing.assert_allclose(one, other, rtol=1e-6)
    assert (plain[1] > 0.0).all() and plain[0].shape == (4, len(JUDGED), 10)


@pytest.mark.parametrize('kind, more', [('kl', 0.1), ('jensen_shannon', 0.08)])
def test_divergence_is_least_for_the_right_answer(kind, more):
    load = torch.tensor(block(2.0).to_message())[None]
    mean, width = load[:, None].clone(), torch.tensor(LABEL_STD, dtype=torch.float64)
    best = divergence(mean, (width ** 2)[None, None], load, kind)
    for worse in (divergence(mean + width, (width ** 2)[None, None], load, kind),
                  divergence(mean, 4.0 * (width ** 2)[None, None], load, kind),
                  divergence(mean, 0.25 * (width ** 2)[None, None], load, kind)):
        assert (worse > best + more).all()


@pytest.mark.parametrize('mean, std, truth, width', [
    (0.0, 1.0, 0.0, 1.0), (2.0, 0.5, 0.0, 1.0), (0.3, 4.0, 0.0, 1e-3), (0.01, 0.05, 0.0, 0.01),
    (1.0, 2.0, 0.0, 1.9), (0.0, 1.0, 30.0, 1.0)])
def test_E6_1_jensen_shannon_is_its_integral(mean, std, truth, width):
    ours, label = norm(mean, std), norm(truth, width)

    def density(x):
        middle = np.logaddexp(ours.logpdf(x), label.logpdf(x)) - np.log(2.0)
        return 0.5 * sum(one.pdf(x) * (one.logpdf(x) - middle) for one in (ours, label))

    ends = np.unique([one.mean() + k * one.std() for one in (ours, label)
                      for k in (-9, -4, 0, 4, 9)])
    wanted = sum(quad(density, *pair, epsabs=1e-12)[0] for pair in zip(ends, ends[1:]))
    one, other, widths = (torch.tensor(x) for x in (mean, truth, [std, width]))
    for dtype, atol in ((torch.float64, 1e-9), (torch.float32, 1e-6)):
        given = [x.to(dtype) for x in (one, widths[0] ** 2, other, widths[1])]
        exchanged = [x.to(dtype) for x in (other, widths[1] ** 2, one, widths[0])]
        np.testing.assert_allclose(jensen_shannon(*given), wanted, atol=atol)
        np.testing.assert_allclose(jensen_shannon(*exchanged), wanted, atol=atol)
    assert wanted < np.log(2.0) + 1e-9


def test_E6_1_the_best_deviation_grows_with_the_error():
    """Smaller variance = more reliable, by either divergence; Jensen-Shannon's is too sure."""
    std = torch.logspace(-3, 1, 120, dtype=torch.float64)[:, None]
    # No error is nothing: on so few that one would count for many.
    z = torch.linspace(-4.0, 4.0, 100, dtype=torch.float64)
    chance, width = torch.exp(-0.5 * z ** 2), torch.tensor(1e-3, dtype=torch.float64)
    best = {kind: np.array([std[(measure(size * z, std ** 2, 0.0 * z, width) * chance)
                                .sum(dim=1).argmin()].item() for size in (0.01, 0.1, 1.0)])
            for kind, measure in DIVERGENCES.items()}
    np.testing.assert_allclose(best['kl'], [0.01, 0.1, 1.0], rtol=0.06)
    assert (best['jensen_shannon'] > [0.004, 0.04, 0.4]).all()
    assert (best['jensen_shannon'] < [0.01, 0.1, 1.0]).all()


@pytest.mark.parametrize('kind', DIVERGENCES)
def test_the_place_of_nothing_is_not_judged(kind):
    nothing = torch.zeros(1, 10, dtype=torch.float64)
    out = divergence(torch.ones(1, 1, 10, dtype=torch.float64),
                     torch.ones(1, 1, 10, dtype=torch.float64), nothing, kind)
    assert (out[0, 0, 1:4] == 0.0).all() and (out[0, 0, [0, 4]] > 0.0).all()


def test_e3_1_features_count_and_missing_temperatures():
    robot, n = four_axes(), 4
    one, ten = np.ones(n), np.full(10, 0.5)
    arguments = [robot.limits, (one, one), (one, one, one), one, (one, one, one), one,
                 (one, one, one), (one, one), ten]
    full = features(*arguments)
    assert full.shape == (n, feature_count(n)) and np.isfinite(full).all()
    arguments[3] = np.full(n, np.nan)
    blind = features(*arguments)
    # Every joint misses its own temperature and is told that there is none.
    assert np.isfinite(blind).all() and np.count_nonzero(full != blind) == 2 * n
    assert (full[:, -1] == 1.0).all() and (blind[:, -1] == 0.0).all()
    arguments[4] = (one, 50.0 * one, 1e9 * one)
    np.testing.assert_array_less(np.abs(features(*arguments)), 2.01)


@pytest.mark.parametrize('batch', [(), (3,)])
def test_features_one_by_one(batch):
    """Every input by its own formula, at the place the weights of shipped networks expect."""
    robot, rng, n = four_axes(), np.random.default_rng(5), 4
    q, v, a, warmth, z, difference, innovation, torque, relative = rng.normal(
        0.0, 3.0, (9, *batch, n))
    doubt, density, variance, excess = np.abs(rng.normal(0.0, 2.0, (4, *batch, n)))
    rmse, intensity = rng.uniform(0.1, 2.0, (2, n))
    std = rng.uniform(1e-5, 1.0, (*batch, 10))
    warmth[..., 1] = np.nan
    got = features(robot.limits, (rmse, intensity), (q, v, a), warmth, (z, doubt, density),
                   difference, (innovation, variance, torque), (relative, excess), std)
    wanted = [np.sin(q), np.cos(q), v / robot.limits.velocity, a / robot.limits.acceleration,
              *(np.arcsinh(x / rmse) / 3.0
                for x in (difference, innovation, np.sqrt(variance), torque)),
              np.nan_to_num(warmth) / 20.0, z, np.minimum(doubt, 1.0),
              np.minimum(np.log(density / intensity) / 6.0, 2.0), np.arcsinh(v / 0.01) / 3.0,
              np.arcsinh(relative) / 3.0, np.minimum(np.log(excess + 0.01) / 3.0, 2.0),
              *(np.broadcast_to(row, q.shape) for row in np.eye(n)),
              *(np.maximum(np.log(std[..., k, None]) / 5.0, -1.4) + 0.0 * q for k in range(10)),
              np.ones_like(q)]
    assert got.shape == (*batch, n, feature_count(n))
    # One entry of the card stands for which joint, one for ten standard deviations.
    assert len(INPUTS) - 2 + n + 10 == feature_count(n)
    np.testing.assert_allclose(got, np.stack(wanted, axis=-1), rtol=1e-13, atol=1e-15)


def test_random_loads_are_bodies_the_hand_may_hold():
    robot, rng = four_axes(), np.random.default_rng(3)
    loads = [random_load(rng, robot) for _ in range(300)]
    mass = np.array([load.mass for load in loads])
    assert mass.max() <= robot.rated_load.mass and 0.02 < np.mean(mass == 0.0) < 0.12
    assert np.ptp(mass) > 0.9 * robot.rated_load.mass
    size = (robot.rated_load.mass / 12.5) ** (1.0 / 3.0)
    most = max(2.0 * share * (half[1] * size) ** 2 for half, share in SHAPES.values())
    for load in loads:
        assert load.is_physical()
        if load.mass:
            assert np.linalg.eigvalsh(load.inertia)[2] < most * load.mass
            assert np.linalg.eigvalsh(pseudo_inertia(load.to_products()))[0] > 0.0
    assert max(abs(load.inertia[0, 1]) for load in loads) > 0.0


@pytest.mark.parametrize('name', SHAPES)
def test_random_loads_are_as_long_as_their_shape_says(monkeypatch, name):
    monkeypatch.setattr(random_loads, 'SHAPES', {name: SHAPES[name]})
    robot, rng = four_axes(), np.random.default_rng(3)
    loads = [random_load(rng, robot, empty=0.0) for _ in range(300)]
    moments = np.array([np.linalg.eigvalsh(load.inertia) / load.mass for load in loads])
    (shortest, longest), share = SHAPES[name]
    # Of every axis the mean square of what lies along it.
    along = 0.5 * moments.sum(axis=1)[:, None] - moments
    half = np.sqrt(along / share) / (robot.rated_load.mass / 12.5) ** (1.0 / 3.0)
    assert shortest - 1e-9 < half.min() < 1.2 * shortest and 0.97 * longest < half.max() \
        < longest + 1e-9


@pytest.mark.parametrize('maker', [random_moves, random_waves, random_motion])
@pytest.mark.parametrize('seed', range(3))
def test_random_motions_are_motions(maker, seed):
    """Velocity and acceleration are the derivatives of position, which stays inside limits."""
    robot, times = four_axes(), np.arange(0.0, 8.0, 0.002)
    q, v, a = maker(np.random.default_rng(seed), robot, times)
    limits = robot.limits
    assert (q >= limits.lower - 1e-9).all() and (q <= limits.upper + 1e-9).all()
    assert (np.abs(v) <= limits.velocity * 1.3).all() and np.abs(v).max() > 0.05
    assert (v[0] == 0.0).all() and (a[0] == 0.0).all()
    np.testing.assert_allclose(np.cumsum((v[1:] + v[:-1]) / 2, axis=0) * 0.002, q[1:] - q[0],
                               atol=2e-3)
    np.testing.assert_allclose(np.cumsum((a[1:] + a[:-1]) / 2, axis=0) * 0.002, v[1:] - v[0],
                               atol=0.03)


def test_friction_turns_over_its_distance_and_rests_where_it_was_left():
    rng, n = np.random.default_rng(4), 3
    truth = draw_friction(rng, np.full(n, 9.0), np.full(n, 2.0), np.zeros(n),
                          np.full(n, 10.0), (np.full(n, 0.1), np.ones(n)),
                          (np.full(n, 1e-3), np.full(n, np.inf)))
    q = np.concatenate([np.linspace(0, 0.02, 300), np.linspace(0.02, 0.0, 300)])[:, None] \
        * np.ones(n)
    v = np.gradient(q, 0.01, axis=0)
    z = friction_state(np.random.default_rng(5), q, v, 0.01, truth)
    # Static friction may exceed sliding friction by a fifth.
    assert (np.abs(z) <= 1.2 + 1e-12).all()
    # Where a joint slows down its level rises, which the contacts have to bend up to.
    np.testing.assert_allclose(z[298], 1.0, atol=1e-3)
    np.testing.assert_allclose(z[-1], -1.0, atol=1e-3)
    assert (z[299] < 0.998).all()
    torque = friction_torque(z, v, truth)
    assert (torque[295] > 5.0).all() and (torque[-5] < -5.0).all()


def test_coloured_noise_has_the_stated_density():
    """Var of the mean over t is density / t once t is long against its memory."""
    rng, dt, density = np.random.default_rng(6), 0.01, np.array([0.04, 0.4])
    means = np.array([coloured_noise(rng, 4000, density, dt).mean(axis=0) for _ in range(60)])
    np.testing.assert_allclose(means.var(axis=0) * 40.0, density, rtol=0.45)


def test_a_sequence_belongs_to_its_seed_alone(model):
    one, again, other = (SequenceMaker(model).make(seed) for seed in (7, 7, 8))
    for name, value in vars(one).items():
        np.testing.assert_array_equal(value, getattr(again, name))
    assert not np.array_equal(one.difference, other.difference)


def test_a_sequence_holds_the_load_it_says(model):
    """Fitting the columns to the differences leaves what model and noise explain."""
    hits, total = 0, 0
    for seed in range(12):
        s = SequenceMaker(model).make(seed)
        n, d = s.columns.shape[1:]
        assert s.difference.shape == (STEPS, n) and np.isfinite(s.difference).all()
        information = Information(n, d - 10)
        for k in range(STEPS):
            information.add_rows(s.columns[k].astype(float), s.difference[k].astype(float),
                                 0.02 / s.density[k].astype(float))
        prior, start = load_prior(model.robot), load_prior(model.robot).mean
        for _ in range(4):
            posterior = posterior_of(information, prior, start)
            start = posterior.shape
        error = posterior.mean[0] - s.load[0]
        assert abs(error) < 0.15 * model.robot.rated_load.mass
        hits += abs(error) < 3.0 * np.sqrt(posterior.covariance[0, 0])
        total += 1
    assert hits >= 0.7 * total


def test_the_shard_is_what_the_network_takes(model, shard):
    assert shard['inputs'].shape == (4, STEPS, 4, feature_count(4))
    for name, value in shard.items():
        assert torch.isfinite(value).all(), name


def test_calibration_makes_95_percent_95_percent(model, tmp_path):
    from safetensors.torch import save_file
    maker, paths = SequenceMaker(model), []
    for k in range(2):
        batch = make_shard(maker, model.robot, range(100 * k, 100 * k + 24))
        paths.append(tmp_path / f'{k}.safetensors')
        save_file({name: value.contiguous() for name, value in batch.items()}, paths[-1])
    prior, network = prior_tensors(model.robot), LoadNetwork(feature_count(4), 4, 6)
    factors = calibrate(network, paths, prior)
    assert factors.shape == (10, len(LEVELS)) and (factors > 0.0).all()
    own = held_out_scores(network, factors, paths, prior)
    coverage = np.array(list(own['coverage_of_95'].values()))
    np.testing.assert_allclose(coverage, 0.95, atol=0.01)
    for narrow in (held_out_scores(network, 0.2 * factors, paths, prior),):
        assert max(narrow['coverage_of_95'].values()) < 0.9
    assert set(own['mass_rmse_kg_lstm']) == {f'{(k + 1) / 10:g} s' for k in TOLD}
    # A network that does nothing has the scores of none.
    assert own['mass_rmse_kg_lstm'] == own['mass_rmse_kg_without_network']


def test_factors_differ_where_the_errors_do(monkeypatch):
    rng = np.random.default_rng(5)
    levels = rng.uniform(-2.5, 0.0, (400, 20, 10))
    # Surer answers err three times as much as they say.
    ratios = rng.normal(size=levels.shape) * np.where(levels < -1.25, 3.0, 1.0)
    severe = np.arange(400) < 40
    ratios[severe] *= 100.0
    monkeypatch.setattr(calibration, '_errors', lambda *_: (ratios, ratios, levels, severe))
    factors = calibrate(None, (), None)
    surer = np.array(LEVELS) < -1.25 - calibration.NEAR
    np.testing.assert_allclose(factors[:, surer], 3.0, rtol=0.1)
    np.testing.assert_allclose(factors[:, np.array(LEVELS) > calibration.NEAR - 1.25], 1.0,
                               rtol=0.1)


def test_coverage_is_told_of_arms_that_there_are(monkeypatch):
    """Without an arm of a kind nothing is divided by none."""
    ratios = np.random.default_rng(6).normal(size=(400, len(JUDGED), 10))
    for severe, there in ((np.zeros(400, bool), ''), (np.ones(400, bool),
                                                      '_with_undeclared_effect')):
        monkeypatch.setattr(calibration, '_errors',
                            lambda *_, s=severe: (ratios, ratios, -np.ones(ratios.shape), s))
        with np.errstate(all='raise'):
            found = held_out_scores(None, np.ones((10, len(LEVELS))), (), None)
        assert [name for name in found if name.startswith('coverage')] == [
            f'coverage_of_95{there}']
        assert abs(found[f'coverage_of_95{there}']['m'] - 0.95) < 0.01


def test_every_joint_overstates_its_noise_by_its_own(model):
    """What is seen of one joint's noise tells nothing of another's."""
    rng, stated = np.random.default_rng(4), model.residuals.intensity
    actual = np.array([_vary(rng, model)[1].intensity for _ in range(400)])
    least, most = (10.0 ** -end for end in OVERSTATED[::-1])
    shares = np.log(actual / stated)
    assert np.log(least) < shares.mean() < np.log(most)
    assert np.abs(np.corrcoef(shares.T) - np.eye(shares.shape[1])).max() < 0.2
