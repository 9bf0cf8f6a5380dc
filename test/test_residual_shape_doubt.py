"""Searched shapes, and what goes with them: intervals hold the truth as often as they say."""

from types import SimpleNamespace

import numpy as np
import pytest
from test_residual_ripple import waving

from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.residual.findings import _of_effect
from hand_load_estimator.residual.measured.blocks import Blocks
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis
from hand_load_estimator.residual.tracing.ripple import likely_periods
from hand_load_estimator.residual.tracing.shape_doubt import (_covariance, NO_DOUBT, shape_doubt,
                                                              ShapeDoubt)
from hand_load_estimator.residual.tracing.shape_fit import settled
from hand_load_estimator.torque.columns import EffectUse

MODEL = SimpleNamespace(uses=())


def case(q, v, residual, weights):
    """Return (Blocks, what holds the EffectInput) of one joint."""
    blocks = Blocks(residual[:, None], weights[:, None], [np.zeros((len(q), 0))],
                    np.arange(0, len(q), 200), np.arange(len(q) // 200) % 5)
    x = SimpleNamespace(q=q[:, None], v=v[:, None], z=np.sign(v)[:, None],
                        warmth=np.zeros((len(q), 1)), shown=None)
    return blocks, SimpleNamespace(x=x, delays={})


def hypothesis_of(name, shape, residual, scale=1.0):
    effect = EFFECTS[name]
    shape = {**effect.default_shape(), **shape}
    columns = scale * effect.columns(residual.x, 0, shape)
    return Hypothesis(name, 0, {0: columns}, np.full(columns.shape[1], scale), shape)


def std_of(name, shape, blocks, residual):
    return shape_doubt(hypothesis_of(name, shape, residual), blocks, MODEL, residual).std


def standard(cost, slopes):
    return np.sqrt(np.diag(_covariance(cost, slopes)))


@pytest.mark.parametrize('size', [0.3, 1.0])
def test_periods_lie_within_their_interval(size):
    """Of 24 ripples in noise as many as a normal distribution has; as wide as they scatter."""
    errors, stds = [], []
    for seed in range(24):
        rows = waving(61.7, size, seed)
        blocks, residual = case(*rows)
        periods = float(likely_periods(*rows)[0][0])
        stds.append(std_of('torque_ripple', {'periods': periods}, blocks, residual)['periods'])
        errors.append(periods - 61.7)
    z = np.array(errors) / stds
    assert 0.5 < np.sqrt(np.mean(z ** 2)) < 1.4 and (np.abs(z) < 2.0).mean() > 0.85
    assert np.std(errors) < 1.6 * np.median(stds) < 4.0 * np.std(errors)


def test_a_larger_effect_is_known_better():
    small, large = (std_of('torque_ripple', {'periods': 61.7}, *case(*waving(61.7, size)))
                    for size in (0.3, 3.0))
    assert 4.0 < small['periods'] / large['periods'] < 25.0


def test_where_the_search_ended_beside_the_best_the_interval_reaches_it():
    blocks, residual = case(*waving(61.7, 1.0))
    best = std_of('torque_ripple', {'periods': 61.7}, blocks, residual)['periods']
    beside = std_of('torque_ripple', {'periods': 61.7 + 3.0 * best}, blocks, residual)['periods']
    assert 2.0 * best < beside < 5.0 * best


def test_what_shows_nowhere_has_no_interval():
    """Faster than every Stribeck velocity nothing of it is left."""
    q, v, residual, weights = waving(61.7, 1.0)
    told = std_of('stribeck_friction', {'stribeck_velocity': 1e-4},
                  *case(q, np.full_like(v, 2.0), residual, weights))
    assert np.isnan(told['stribeck_velocity'])


def test_a_shape_without_a_maximum_leaves_the_others_their_interval():
    cost, slopes = np.array([[4.0, 0.1, 0.0], [0.1, -1.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros((3, 5))
    np.testing.assert_allclose(standard(cost, slopes), [0.5, np.nan, 1.0])
    # Two that make up for one another are each known worse than alone.
    assert (standard(np.array([[1.0, 0.9], [0.9, 1.0]]), slopes[:2]) > 2.0).all()
    assert np.isnan(standard(-np.eye(2), slopes[:2])).all()


def test_blocks_that_disagree_widen_the_interval():
    slopes = np.array([[3.0, -3.0, 3.0, -3.0]])
    assert standard(np.eye(1), slopes)[0] == pytest.approx(6.0)
    assert standard(np.eye(1), 0.1 * slopes)[0] == pytest.approx(1.0)


def test_a_level_is_doubted_as_the_velocity_is_at_which_it_falls():
    """Of 24 peaks whose slow end is not seen; with the shape held where it is too few hold."""
    offs, with_shape, alone = [], [], []
    for seed in range(24):
        rng = np.random.default_rng(seed)
        v = 0.2 + 0.15 * np.sin(np.arange(4000) * 0.02)
        noise = rng.normal(0.0, 0.05, len(v))
        blocks, residual = case(np.cumsum(v) * 0.02, v, 2.0 * np.exp(-v / 0.1) + noise,
                                np.full(len(v), 1.0 / 0.05 ** 2))
        start = hypothesis_of('stribeck_friction', {'stribeck_velocity': 0.1}, residual)
        (found, score), _ = settled(start, blocks.evaluate(start.columns), blocks, MODEL,
                                    residual, lambda _, of: of.gain)
        doubt = shape_doubt(found, blocks, MODEL, residual)
        offs.append(score.theta[0] - 2.0)
        alone.append(score.covariance[0, 0] ** 0.5)
        with_shape.append((score.covariance[0, 0] + doubt.of_parameters[0, 0]) ** 0.5)
    z = np.array(offs) / with_shape
    assert 0.5 < np.sqrt(np.mean(z ** 2)) < 1.4 and (np.abs(z) < 2.0).mean() > 0.85
    assert np.median(with_shape) > 2.0 * np.median(alone)


def test_the_doubt_of_parameters_is_in_their_units():
    """Whatever the prior's unit, as long as it leaves the parameters free."""
    rows = waving(61.7, 1.0)
    small, large = (shape_doubt(hypothesis_of('torque_ripple', {'periods': 61.7}, residual, scale),
                                blocks, MODEL, residual).of_parameters
                    for blocks, residual in [case(*rows)] for scale in (5.0, 50.0))
    np.testing.assert_allclose(small, large, rtol=0.02, atol=1e-3 * large.max())
    assert large.max() > 0.0


@pytest.mark.parametrize('name, shape, wider', [
    ('stribeck_friction', {'stribeck_velocity': 0.1}, True),
    ('torque_ripple', {'periods': 60.0}, True), ('time_delay', {'shift': 0.02}, False)])
def test_a_report_widens_parameters_and_not_what_is_derived_of_them(name, shape, wider):
    """A ripple's amplitude does not turn with its period; of a delay only the product is told."""
    use = EffectUse(name, 0, shape)
    size = len(use.effect.parameters)
    better = SimpleNamespace(mean=np.full(size, 1.0), covariance=1e-4 * np.eye(size),
                             slices=lambda: [(use, slice(0, size))])
    hypothesis = Hypothesis(name, 0, {}, np.ones(size), use.shape)
    told, plain = (_of_effect(SimpleNamespace(slices=lambda: []), better, hypothesis, doubt)
                   for doubt in (ShapeDoubt({}, 3e-4 * np.eye(size)), NO_DOUBT))
    own = [parameter for parameter, _ in use.effect.parameters]
    for figure in own:
        assert told[figure][1] == pytest.approx(0.02 if wider else 0.01)
    for figure in set(plain) - set(own):
        np.testing.assert_equal(told[figure], plain[figure])
