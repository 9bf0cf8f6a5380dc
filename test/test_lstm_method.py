"""The LSTM as a method: beside Bayes, with its calibration, through changes, resets, restarts."""

from copy import copy
from dataclasses import replace

from core_helpers import block, exact_model, feed, four_axes, messages, pipeline_of, warm
from lstm_helpers import artefact_of, loud_network, network_of, pipeline_with
import numpy as np
import pytest

from hand_load_estimator.estimators.checkpoint import (belongs_to, CheckpointError,
                                                       restore_checkpoint, write_checkpoint)
from hand_load_estimator.learning.interval_factors import factors_at, level_of, LEVELS
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.torque import misread_weight


@pytest.fixture(scope='module')
def robot():
    return four_axes()


@pytest.fixture(scope='module')
def silent(tmp_path_factory, robot):
    """Return the artefact of a network that has learnt nothing: all outputs zero."""
    network = network_of(robot, size=0.0)
    return artefact_of(tmp_path_factory.mktemp('silent'), robot, network)


@pytest.fixture(scope='module')
def loud(tmp_path_factory, robot):
    """Return (network, artefact) of a network that speaks on all outputs."""
    return loud_network(tmp_path_factory.mktemp('loud'), robot)


def doubtful(model, doubt):
    """Return a TorqueModel of an arm whose torque constants may be off by a share."""
    robot = copy(model.robot)
    robot.effort = replace(robot.effort, torque_constants_std=doubt)
    return replace(model, robot=robot)


def model_without_temperatures():
    """Return a TorqueModel that no temperature changes."""
    return exact_model('four', ('coulomb_friction', 'viscous_friction'))


@pytest.fixture
def sure(monkeypatch):
    """Let nothing misread weights: `bayes` looks for it a sample sooner than `lstm` at times."""
    for name in ('LEAN', 'GAIN', 'TOOTH_FRICTION'):
        monkeypatch.setattr(misread_weight, name, 1e-9)


def test_a_network_that_says_nothing_is_bayes(silent, sure):
    model = exact_model('four')
    stream = messages(model, block(2.0), 4.0)
    plain = feed(warm(pipeline_of(model)), stream)
    ours = feed(warm(pipeline_with(model, silent)), stream)
    for one, other in zip(plain[::10], ours[::10]):
        np.testing.assert_allclose(one.mean, other.mean, atol=1e-6)
        np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-4, atol=1e-12)


def test_what_was_tared_is_what_its_estimates_are_beside(loud):
    """The network's corrections are in the estimate, so they are in the zero, too."""
    model = exact_model('four')
    pipeline = warm(pipeline_with(model, loud[1]))
    feed(pipeline, messages(model, block(2.0), 4.0))
    pipeline.settle()
    method = pipeline.method
    held = [regression.widened().products for regression in (method._learned, method._plain)]
    method.tare()
    np.testing.assert_allclose(method.tared, held[0], rtol=1e-3, atol=1e-6)
    assert abs(held[1] - held[0])[0] > 0.003
    np.testing.assert_array_equal(pipeline.known_load, method.tared)


@pytest.mark.parametrize('doubt, near', [(0.0, 1e-5), (0.05, 0.02)])
def test_a_network_trained_beside_temperatures_is_not_asked_without_them(
        loud, sure, doubt, near):
    """
    Nor with some of them; one that was trained without any is.

    The residuals behind it are counted without the doubt about torque constants.
    """
    model = doubtful(exact_model('four'), doubt)
    network, artefact = loud
    stream = messages(model, block(2.0), 3.0)
    plain, ours, knows = pipeline_of(model), pipeline_with(model, artefact), pipeline_with(
        model, replace(artefact, card={**artefact.card, 'temperatures': False}))
    for pipeline in (plain, ours, knows):
        pipeline.temperature_reading(model.robot.joints[0], 25.0)
    plain, ours, knows = (feed(pipeline, stream) for pipeline in (plain, ours, knows))
    for one, other in zip(plain[::10], ours[::10]):
        assert (np.abs(one.mean - other.mean) < near * one.std).all()
        np.testing.assert_allclose(one.std, other.std, rtol=near)
    assert np.abs(knows[-1].mean - plain[-1].mean).max() > 0.1 * plain[-1].std.min()
    assert np.abs(np.log(knows[-1].std / plain[-1].std)).max() > 0.1


def test_temperatures_change_nothing_for_a_network_trained_without_them(loud):
    """Weights of what was the same all along were never trained."""
    model = model_without_temperatures()
    artefact = replace(loud[1], card={**loud[1].card, 'temperatures': False})
    stream = messages(model, block(2.0), 2.0)
    cold, hot = pipeline_with(model, artefact), warm(pipeline_with(model, artefact), 45.0)
    for one, other in zip(feed(cold, stream)[::20], feed(hot, stream)[::20]):
        np.testing.assert_array_equal(one.mean, other.mean)
        np.testing.assert_array_equal(one.covariance, other.covariance)


def test_a_network_is_asked_while_every_temperature_is_known(loud):
    """What it said before is not said again of later motions."""
    model = exact_model('four')
    pipeline = pipeline_with(model, loud[1])
    stream = messages(model, block(2.0), 6.0)
    said = []
    for part, celsius in zip((stream[:200], stream[200:400], stream[400:]), (None, 25.0, None)):
        if celsius is not None:
            warm(pipeline, celsius)
        elif said:
            pipeline.method.settle()
            pipeline._stream._filter.temperature[2] = np.nan
        last = feed(pipeline, part)[-1]
        said.append((last, pipeline.reliability['network'], pipeline.method._shift.any()))
    assert [told == 'asked' for _, told, _ in said] == [False, True, False]
    assert [shifted for *_, shifted in said] == [False, True, False]
    assert 'not of all joints' in said[2][1]


@pytest.mark.parametrize('doubt', [0.0, 0.05])
def test_a_checkpoint_says_whether_the_network_was_asked(loud, doubt, tmp_path):
    model = doubtful(exact_model('four'), doubt)
    old, new = (pipeline_with(model, loud[1]) for _ in range(2))
    feed(old, messages(model, block(3.0), 3.0))
    write_checkpoint(tmp_path / 'c', old.state(), belongs_to(old))
    restore_checkpoint(tmp_path / 'c', new, 60.0)
    before, after = old.method.belief(), new.method.belief()
    # Friction and offsets are found anew.
    np.testing.assert_allclose(np.sqrt(np.diag(after.covariance) / np.diag(before.covariance)),
                               1.0, atol=0.05)


def test_the_network_changes_the_answer(silent, loud):
    model = exact_model('four')
    stream = messages(model, block(2.0), 2.5)
    quiet = feed(warm(pipeline_with(model, silent)), stream)[-1]
    spoken = feed(warm(pipeline_with(model, loud[1])), stream)[-1]
    moved = np.abs(spoken.mean - quiet.mean) / quiet.std
    widened = np.abs(np.log(spoken.std / quiet.std))
    assert moved.max() > 0.1 and widened.max() > 0.1, (moved, widened)
    assert np.abs(np.log(spoken.std / quiet.std)).max() > 0.1


def test_calibration_scales_standard_deviations(tmp_path, robot, silent):
    factors = np.linspace(0.8, 2.0, 10)[:, None] * np.ones(len(LEVELS))
    wide = artefact_of(tmp_path, robot, network_of(robot, size=0.0), factors)
    model = exact_model('four')
    stream = messages(model, block(2.0), 2.0)
    one, other = (feed(warm(pipeline_with(model, a)), stream)[-1] for a in (silent, wide))
    np.testing.assert_allclose(other.std / one.std, factors[:, 0], rtol=1e-5)
    np.testing.assert_array_equal(other.mean, one.mean)


def test_factors_follow_how_well_a_parameter_is_determined():
    factors = np.tile(np.arange(1.0, 1.0 + len(LEVELS)), (10, 1))
    level = level_of(np.full(10, 10.0 ** (0.3 * LEVELS[2] + 0.7 * LEVELS[3])), np.ones(10))
    np.testing.assert_allclose(factors_at(factors, level), 3.7)
    # Beyond the levels the outermost factors hold.
    np.testing.assert_allclose(factors_at(factors, np.full(10, -4.0)), 1.0)
    np.testing.assert_allclose(factors_at(factors, level_of(np.full(10, 3.0), np.ones(10))),
                               len(LEVELS))


def test_factors_are_interpolated_linearly_one_row_each():
    rng = np.random.default_rng(1)
    factors, level = rng.uniform(0.5, 3.0, (10, len(LEVELS))), rng.uniform(-3.0, 0.5, 10)
    # Shares by distance are an interpolation at even spacing only.
    assert np.ptp(np.diff(LEVELS)) == 0.0
    np.testing.assert_allclose(
        factors_at(factors, level),
        [np.interp(x, LEVELS, row) for x, row in zip(level, factors)], rtol=1e-13)


def test_an_arm_that_stands_is_told_no_more_of_the_load(loud):
    """Shift and spread stay while it stands, zero before it has moved."""
    model = exact_model('four')
    stream = messages(model, block(2.0), 3.0)
    pipeline = warm(pipeline_with(model, loud[1]))
    method = pipeline.method
    feed(pipeline, stream[:55])
    assert not np.any(method._shift) and not np.any(method._spread)
    assert np.any(method._cell.memory)
    feed(pipeline, stream[55:])
    shift, spread, memory = method._shift, method._spread, method._cell.memory
    assert np.abs(shift).min() > 0.0 and np.abs(spread).min() > 0.0
    # Held where it is, until the filtered velocity has come to rest, and on.
    last = stream[-1]
    held = [replace(last, stamp=last.stamp + 0.01 * k, position=last.position,
                    velocity=0.0 * last.velocity) for k in range(1, 121)]
    feed(pipeline, held[:60])
    shift, spread = method._shift, method._spread
    feed(pipeline, held[60:])
    np.testing.assert_array_equal(method._shift, shift)
    np.testing.assert_array_equal(method._spread, spread)
    assert np.abs(method._cell.memory[0] - memory[0]).max() > 0.0


def test_a_push_on_an_arm_that_stands_leaves_what_was_said(loud):
    model = exact_model('four')
    pipeline = warm(pipeline_with(model, loud[1]))
    feed(pipeline, messages(model, block(2.0), 3.0))
    method = pipeline.method
    said = method._shift.copy(), method._spread.copy()
    stamp = 103.0
    method._plain.begin_anew(stamp)
    method._learned.begin_anew(stamp)
    method._restart()
    assert not np.any(method._shift)
    method._take_back(stamp + 0.1)
    np.testing.assert_array_equal((method._shift, method._spread), said)
    np.testing.assert_allclose(method._learned.posterior.shape, method._plain.posterior.shape,
                               atol=1.0)


def test_a_changed_load_is_noticed_in_step_with_bayes(silent):
    model = exact_model('four')
    # Of another noise one may see it two samples before the other: they look in turns of their own.
    stream = messages(model, LoadParameters(), 5.0, change=(2.5, block(2.0)), seed=2)
    bayes, pipeline = warm(pipeline_of(model)), warm(pipeline_with(model, silent))
    plain, ours = feed(bayes, stream), feed(pipeline, stream)
    assert [e.load_id for e in ours] == [e.load_id for e in plain]
    assert pipeline.load_id > 0
    # Both regressions must have dropped the same data and expect the same.
    assert pipeline.method._learned.expected is pipeline.method._plain.expected
    # The load before, around which both expect it, is solved from other starts.
    np.testing.assert_allclose(ours[-1].mean, plain[-1].mean, atol=1e-4)
    np.testing.assert_allclose(ours[-1].std, plain[-1].std, rtol=1e-3)


def test_reset_and_tare_reach_the_network(silent, loud):
    model = exact_model('four')
    stream = messages(model, block(2.0), 2.5)
    for artefact in (silent, loud[1]):
        pipeline = warm(pipeline_with(model, artefact))
        fresh = pipeline.estimate(0.0)
        feed(pipeline, stream)
        pipeline.reset()
        np.testing.assert_allclose(pipeline.estimate(0.0).mean, fresh.mean)
        np.testing.assert_allclose(pipeline.estimate(0.0).covariance, fresh.covariance)
    pipeline, plain = warm(pipeline_with(model, silent)), warm(pipeline_of(model))
    for p in (pipeline, plain):
        feed(p, stream)
        p.tare(p.last_stamp)
        feed(p, [type(m)(m.stamp + 3.0, *list(vars(m).values())[1:]) for m in stream])
    np.testing.assert_allclose(pipeline.estimate(0.0).mean, plain.estimate(0.0).mean, atol=1e-5)


def test_the_artefact_runs_with_any_model_of_the_arm(robot, loud):
    """Another model of the same joints: other effects, other numbers of nuisances."""
    for model in (exact_model('four'), exact_model('four', ('coulomb_friction',)),
                  exact_model('four', doubt=0.05)):
        last = feed(warm(pipeline_with(model, loud[1])), messages(model, block(2.0), 1.5))[-1]
        assert np.isfinite(last.mean).all() and (last.std > 0.0).all()


def test_the_network_goes_on_from_a_checkpoint(robot, loud, tmp_path):
    model = exact_model('four')
    old, new = (warm(pipeline_with(model, loud[1])) for _ in range(2))
    feed(old, messages(model, block(3.0), 3.0))
    write_checkpoint(tmp_path / 'c', old.state(), belongs_to(old))
    restore_checkpoint(tmp_path / 'c', new, 60.0)
    # How far the model is trusted since it settled counts from the next sample on.
    old.method._learned.update_posterior()
    before, after = old.method.belief(), new.method.belief()
    std = np.sqrt(np.diag(before.covariance))
    np.testing.assert_allclose(after.mean / std, before.mean / std, atol=1e-3)
    np.testing.assert_allclose(after.covariance / np.outer(std, std),
                               before.covariance / np.outer(std, std), atol=1e-3)
    assert new.method.state()['memory'].any()
    other = artefact_of(tmp_path / 'b', robot, network_of(robot, seed=2))
    with pytest.raises(CheckpointError, match='another learned artefact'):
        restore_checkpoint(tmp_path / 'c', pipeline_with(model, other), 60.0)
