"""Collision thresholds: follow load and variance, never above the fixed one; detection."""

from dataclasses import replace

import numpy as np
import pytest
from control_helpers import HOME, PICK, PLACE, WARM, FakeModel, belief, load_vector

from hand_load_estimator.control.acceleration_limits import MovePlanner
from hand_load_estimator.control.collision_threshold import (CollisionDetector,
                                                             CollisionThresholds, Thresholds,
                                                             ThresholdSettings)
from hand_load_estimator.control.load_belief import (LoadBelief, belief_of_estimate,
                                                     rated_belief)
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import products_from_message
from hand_load_estimator.torque.model_file import read_model

MODEL = FakeModel()
SETTINGS = ThresholdSettings()
CALCULATION = CollisionThresholds(MODEL, SETTINGS)
RATED = rated_belief(MODEL.robot)
MOVING = (HOME, np.array([0.8, -0.6, 0.7, 0.5, 0.4, -0.6]), np.full(6, 0.5))


def test_the_threshold_grows_with_the_variance_up_to_the_fixed_one():
    before = np.zeros(6)
    for std in (0.01, 0.1, 0.5, 2.0, 5.0, 50.0):
        now, fixed = CALCULATION.at(*MOVING, belief(4.0, std, com_std=0.02 * std), WARM)
        assert np.all(now.threshold >= before - 1e-9) and np.all(now.threshold <= fixed + 1e-9)
        before = now.threshold
    np.testing.assert_allclose(before, fixed)


def test_a_known_load_is_much_tighter_than_the_fixed_threshold():
    now, fixed = CALCULATION.at(*MOVING, belief(4.0), WARM)
    assert np.all(now.threshold[1:3] < 0.5 * fixed[1:3])
    np.testing.assert_allclose(CALCULATION.at(*MOVING, RATED, WARM)[0].threshold, fixed)


def test_the_expected_torque_is_the_loads():
    vector = load_vector(4.0)
    now, _ = CALCULATION.at(*MOVING, belief(4.0), WARM)
    expected = MODEL.load_regressor(*MOVING) @ products_from_message(vector)
    np.testing.assert_allclose(now.expected, expected)


def test_without_an_estimate_every_load_up_to_the_rated_one_is_within():
    rng = np.random.default_rng(5)
    for _ in range(200):
        com = rng.normal(size=3)
        com *= 0.1 * rng.uniform() / np.linalg.norm(com)
        vector = load_vector(rng.uniform(0.0, 12.5), com + [0.0, 0.0, 0.05])
        state = (PICK + rng.normal(size=6), 0.5 * rng.normal(size=6), rng.normal(size=6))
        now, _ = CALCULATION.at(*state, RATED, WARM)
        torque = MODEL.load_regressor(*state) @ products_from_message(vector)
        assert np.all(np.abs(torque - now.expected) <= now.threshold)


def test_a_resting_joint_may_hold_its_friction():
    still = np.zeros(6)
    rest, _ = CALCULATION.at(HOME, still, still, belief(4.0), WARM)
    moving, _ = CALCULATION.at(HOME, np.full(6, 0.3), still, belief(4.0), WARM)
    assert np.all(rest.threshold - moving.threshold > 1.9 * MODEL.coulomb)


def test_an_unknown_temperature_widens_the_threshold_by_its_friction():
    model = read_model(find_shared('ur10e', 'models'))
    thresholds, known = CollisionThresholds(model, SETTINGS), belief(4.0)
    q, v, still = HOME, np.array([1.0, -1.0, 1.0, 1.5, -1.5, 1.5]), np.zeros(6)
    measured, _ = thresholds.at(q, v, still, known, WARM)
    blind, _ = thresholds.at(q, v, still, known, np.full(6, np.nan))
    reference = model.torque(q, v, still, np.full(6, np.nan))
    cold, warm = (np.abs(model.torque(q, v, still, np.full(6, celsius)) - reference)
                  for celsius in (-5.0, 55.0))
    assert np.all(cold > measured.threshold), 'taken for 25 degC, a cold arm would be a collision'
    assert np.all(cold < blind.threshold) and np.all(warm < blind.threshold)
    measured, blind = (thresholds.at(q, still, still, known, t)[0].threshold for t in (
        WARM, np.full(6, np.nan)))
    # At rest only the Coulomb level is as unsure as its own slope with temperature says.
    assert np.all(measured < blind) and np.all(blind < 1.03 * measured)


def test_the_models_own_uncertainty_is_in_the_threshold():
    model = read_model(find_shared('ur10e', 'models'))
    exact = replace(model, covariance=np.zeros_like(model.covariance),
                    residuals=replace(model.residuals, drift=np.zeros((6, 3))))
    with_doubt, without = (CollisionThresholds(m, SETTINGS).at(
        HOME, np.full(6, 0.8), np.zeros(6), belief(4.0), WARM)[0].threshold
        for m in (model, exact))
    drift = model.residuals.drift @ [1.0, 0.0, 0.8]
    assert np.all(with_doubt - without > 0.5 * SETTINGS.sigma * drift)


@pytest.mark.parametrize('sigma', [0.0, -1.0, np.nan])
def test_a_sigma_that_bounds_nothing_is_refused(sigma):
    with pytest.raises(ValueError, match='sigma'):
        CollisionThresholds(MODEL, ThresholdSettings(sigma=sigma))


@pytest.mark.parametrize('value', [np.nan, np.inf])
def test_an_estimate_that_is_not_finite_leaves_the_fixed_threshold(value):
    broken = LoadBelief(np.full(10, value), np.full((10, 10), value), 'estimate')
    with np.errstate(invalid='ignore'):
        now, fixed = CALCULATION.at(*MOVING, broken, WARM)
    np.testing.assert_array_equal(now.threshold, fixed)
    assert np.isfinite(fixed).all() and np.isfinite(now.expected).all()


def test_a_threshold_that_is_not_a_number_is_no_permission():
    detector = CollisionDetector(SETTINGS)
    for k in range(5):
        detector.record(0.01 * k, known(np.nan), np.full(6, 99.0))
        detector.check(0.01 * k, np.zeros(6))
    assert detector.collided


def run(load_belief, vector, push=None, seed=0):
    """Return the detector after PICK -> PLACE with a true load and a push [Nm] after 0.5 s."""
    rng, detector = np.random.default_rng(seed), CollisionDetector(SETTINGS)
    move = MovePlanner(MODEL).plan(PICK, PLACE, load_belief, WARM)
    products = products_from_message(vector)
    for t in np.arange(0.0, move.duration, 0.01):
        state = [x[0] for x in move.points([t])]
        detector.record(t, *CALCULATION.at(*state, load_belief, WARM))
        # The estimator's residual is late by its filter.
        late = [x[0] for x in move.points([max(0.0, t - 0.03)])]
        residual = MODEL.load_regressor(*late) @ products + MODEL.noise * rng.normal(size=6)
        if push is not None and t > 0.5:
            residual = residual + push
        if detector.check(t, residual):
            return detector, t
    return detector, None


@pytest.mark.parametrize('mass', [0.0, 4.0, 10.0])
def test_no_false_alarm_with_a_load_inside_its_interval(mass):
    std = 0.1 + 0.02 * mass
    for k in range(5):
        true = load_vector(mass + std * (k - 2))
        detector, _ = run(belief_of_estimate(load_vector(mass), belief_spread(std)), true, seed=k)
        assert not detector.collided, detector.what
    detector, _ = run(RATED, load_vector(mass))
    assert not detector.collided, detector.what


def belief_spread(std):
    return np.diag(np.array([std] + [0.005] * 3 + [0.005] * 6) ** 2)


def test_a_push_is_found_soon_with_a_known_load_and_later_or_not_without():
    push = np.array([0.0, 35.0, 25.0, 0.0, 0.0, 0.0])
    detector, when = run(belief(4.0), load_vector(4.0), push)
    assert detector.collided and when < 0.5 + 0.1
    joints, beyond, threshold = detector.what
    assert set(joints) <= {1, 2} and np.all(beyond[joints] > threshold[joints])
    assert not run(RATED, load_vector(4.0), push)[0].collided


def known(threshold, expected=0.0):
    return Thresholds(np.full(6, expected), np.full(6, threshold))


def test_debounce_latch_and_reset():
    detector, high, fixed = CollisionDetector(SETTINGS), np.full(6, 9.0), np.full(6, 99.0)
    for k in range(20):
        detector.record(k * 0.01, known(5.0), fixed)
        detector.check(k * 0.01, high if k % 3 else np.zeros(6))
    assert not detector.collided, 'two in a row are not three'
    for k in range(20, 23):
        detector.record(k * 0.01, known(5.0), fixed)
        detector.check(k * 0.01, high)
    assert detector.collided
    assert detector.check(0.23, np.zeros(6)), 'latched'
    detector.reset()
    assert not detector.collided and detector.what is None
    for k in range(23, 40):
        detector.record(k * 0.01, known(5.0), fixed)
        detector.check(k * 0.01, high)
        assert detector.collided == (k * 0.01 > 0.22 + SETTINGS.delay + 0.015)


def test_rare_residuals_are_debounced_by_time():
    detector, settings = CollisionDetector(replace(SETTINGS, debounce=10)), SETTINGS
    for k in range(6):
        detector.record(0.1 * k, known(5.0), np.full(6, 99.0))
        detector.check(0.1 * k, np.full(6, 9.0))
        assert detector.collided == (0.1 * k > settings.debounce_time - 0.05)


def test_nan_and_old_residuals_are_no_collision():
    detector = CollisionDetector(SETTINGS)
    detector.record(10.0, known(5.0), np.full(6, 99.0))
    for _ in range(10):
        detector.check(10.0, np.full(6, np.nan))
        detector.check(3.0, np.full(6, 1000.0))
    assert not detector.collided


def test_thresholds_rise_at_once_and_fall_slowly_but_not_above_the_fixed():
    detector, fixed = CollisionDetector(SETTINGS), np.full(6, 40.0)
    assert detector.record(0.0, known(5.0), fixed).threshold[0] == 5.0
    assert detector.record(0.01, known(30.0), fixed).threshold[0] == 30.0
    falling = [detector.record(0.02 + 0.01 * k, known(5.0), fixed).threshold[0]
               for k in range(200)]
    assert 28.0 < falling[0] < 30.0 and np.all(np.diff(falling) < 0.0)
    assert falling[-1] == pytest.approx(5.0, abs=0.1)
    detector.record(3.0, known(39.0), fixed)
    assert np.all(detector.record(3.01, known(5.0), np.full(6, 20.0)).threshold <= 20.0)
