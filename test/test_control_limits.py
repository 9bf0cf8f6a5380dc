"""Acceleration and deceleration limits: torque kept, safe side, E8.1 to E8.3, braking."""

import numpy as np
import pytest
from control_helpers import (FAR_PICK, FAR_PLACE, HOME, PICK, WARM, FakeModel, belief,
                             load_vector, torque_with_load)

from hand_load_estimator.control.acceleration_limits import MovePlanner, PlanSettings
from hand_load_estimator.control.braking import braking_trajectory
from hand_load_estimator.control.load_belief import belief_of_estimate, rated_belief
from hand_load_estimator.control.torque_use import TorqueUse
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import products_from_message, products_jacobian_of_message
from hand_load_estimator.torque.model_file import read_model

MODEL = FakeModel(agility=3.0)
ROBOT = MODEL.robot
ALLOWED = ROBOT.limits.allowed_torque * ROBOT.limits.torque
PLANNER = MovePlanner(MODEL)


def fast(mass, **how):
    return PLANNER.plan(FAR_PICK, FAR_PLACE, belief(mass, **how), WARM)


def test_products_jacobian_matches_differences():
    vector = np.random.default_rng(2).normal(size=10)
    numeric = np.array([(products_from_message(vector + d) - products_from_message(vector - d))
                        / 2e-6 for d in 1e-6 * np.eye(10)]).T
    np.testing.assert_allclose(products_jacobian_of_message(vector), numeric, atol=1e-8)


def test_belief_has_the_moments_of_the_products_drawn():
    rng = np.random.default_rng(3)
    covariance = np.diag(np.array([2.0, 0.05, 0.05, 0.05] + [1e-3] * 6) ** 2)
    mean = load_vector(3.0)
    drawn = products_from_message(rng.multivariate_normal(mean, covariance, 200000))
    std = np.sqrt(np.diag(belief_of_estimate(mean, covariance).covariance))
    np.testing.assert_allclose(std[:4], drawn.std(axis=0)[:4], rtol=0.02)


@pytest.mark.parametrize('mass, spread', [
    (0.0, {}), (5.0, {}), (9.0, {'mass_std': 0.5, 'com_std': 0.02}),
    (2.0, {'mass_std': 2.0, 'com_std': 0.05}), (11.0, {'mass_std': 0.02})])
def test_no_load_within_three_sigma_exceeds_the_allowed_torque(mass, spread):
    load = belief(mass, **spread)
    move = PLANNER.plan(FAR_PICK, FAR_PLACE, load, WARM)
    assert move.feasible and move.basis == 'estimate'
    rng = np.random.default_rng(4)
    root = np.linalg.cholesky(load.covariance + 1e-12 * np.eye(10))
    directions = rng.normal(size=(40, 10))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    loads = load.mean + 3.0 * directions @ root.T
    times = np.linspace(0.0, move.duration, 97)
    for q, v, a in zip(*move.points(times)):
        torque = MODEL.torque(q, v, a) + loads @ MODEL.load_regressor(q, v, a).T
        assert np.all(np.abs(torque) <= 1.005 * ALLOWED)


def test_the_torque_of_the_mean_load_agrees_with_rnea():
    vector = load_vector(9.0, (0.03, -0.02, 0.12))
    move = PLANNER.plan(FAR_PICK, FAR_PLACE, belief_of_estimate(vector, np.zeros((10, 10))), WARM)
    times = np.linspace(0.0, move.duration, 97)
    shares = [np.max(np.abs(torque_with_load(MODEL, vector, *x)) / ALLOWED)
              for x in zip(*move.points(times))]
    assert 0.9 < max(shares) <= 1.005


def test_the_limits_are_used_up():
    for mass in (9.0, 11.0):
        move = fast(mass)
        assert PLANNER.use(move, belief(mass), WARM) > 0.97
        assert min(move.limits.acceleration / move.top.acceleration,
                   move.limits.deceleration / move.top.deceleration) < 1.0


def test_configured_limits_are_never_exceeded():
    move = fast(0.0)
    _, v, a = move.points(np.linspace(0.0, move.duration, 400))
    assert np.all(np.abs(v) <= ROBOT.limits.velocity * 1.000001)
    assert np.all(np.abs(a) <= ROBOT.limits.acceleration * 1.000001)
    limits = move.motion_limits(ROBOT.limits, 1.0)
    np.testing.assert_allclose(limits.acceleration, ROBOT.limits.acceleration)


def test_moves_keep_the_limits_they_announce():
    for mass in (0.0, 9.0, 11.0):
        move = fast(mass)
        limits = move.motion_limits(ROBOT.limits, 1.0)
        t = np.linspace(0.0, move.duration, 400)
        _, v, a = move.points(t)
        speeding_up = (a * v).sum(axis=1) > 0.0
        assert np.all(np.abs(a[speeding_up]) <= limits.acceleration * 1.000001)
        assert np.all(np.abs(a[~speeding_up]) <= limits.deceleration * 1.000001)
        assert np.all(np.abs(v) <= limits.velocity * 1.000001)
        assert np.all(limits.acceleration > 0.0) and np.all(limits.deceleration > 0.0)


def test_heavier_is_never_faster():
    durations = [fast(mass).duration for mass in (0.0, 3.0, 6.0, 9.0, 11.0)]
    assert np.all(np.diff(durations) >= -0.01) and durations[-1] > durations[0] + 0.1


def test_wider_is_never_faster():
    durations = [fast(7.0, mass_std=std, com_std=0.01 + 0.01 * std).duration
                 for std in (0.01, 0.1, 0.3, 0.6, 1.0, 1.5, 3.0)]
    assert np.all(np.diff(durations) >= -0.01) and durations[-1] > durations[0] + 0.05


def test_never_slower_than_with_the_rated_load():
    # Nearer in, where the arm can carry its rated load.
    rated = PLANNER.plan(PICK, HOME, rated_belief(ROBOT), WARM)
    assert rated.feasible
    for std in (0.1, 1.0, 3.0, 10.0):
        move = PLANNER.plan(PICK, HOME, belief(6.0, mass_std=std, com_std=0.1), WARM)
        assert move.feasible and move.duration <= rated.duration + 1e-9
    known = PLANNER.plan(PICK, HOME, belief(1.0), WARM)
    assert known.basis == 'estimate' and known.duration <= rated.duration


def test_a_load_known_to_be_heavier_than_rated_is_not_moved_at_the_rated_limits():
    start, goal = HOME, np.array([-0.9, -1.3, 1.9, -2.17, -1.57, -0.5])
    rated = PLANNER.plan(start, goal, rated_belief(ROBOT), WARM)
    heavy = PLANNER.plan(start, goal, belief(14.5), WARM)
    assert rated.feasible and heavy.duration > rated.duration
    assert not heavy.feasible or PLANNER.use(heavy, belief(14.5), WARM) <= 1.005


def test_a_load_too_heavy_to_hold_is_said_and_moved_slowly():
    move = fast(30.0)
    assert not move.feasible and 'no acceleration keeps' in move.reason
    assert move.duration > 2.0 * fast(5.0).duration


def test_caution_goes_from_the_estimate_to_the_rated_load():
    start, goal = PICK, HOME
    light, rated = belief(1.0), rated_belief(ROBOT)
    speeds = [PLANNER.plan(start, goal, light, WARM, caution).duration
              for caution in (0.0, 0.5, 1.0)]
    assert np.all(np.diff(speeds) >= -1e-9)
    assert speeds[-1] == pytest.approx(PLANNER.plan(start, goal, rated, WARM).duration, rel=0.02)


def test_the_rest_of_a_move_gets_faster_for_a_light_load_and_stays_on_the_path():
    move = fast(11.0)
    elapsed = 0.3 * move.duration
    rest = PLANNER.rest(move, elapsed, belief(1.0), WARM)
    assert elapsed + rest.duration < move.duration - 0.02
    for old, new in zip(move.points([elapsed]), rest.points([0.0])):
        np.testing.assert_allclose(old, new, atol=1e-9)
    np.testing.assert_allclose(rest.points([rest.duration])[0][0], FAR_PLACE, atol=1e-12)


def test_the_rest_of_a_move_brakes_more_gently_for_a_heavy_load():
    move = fast(0.0)
    elapsed = move.profile.acceleration_time
    heavy = belief(10.5)
    assert PLANNER.use(move, heavy, WARM, elapsed) > 1.0
    rest = PLANNER.rest(move, elapsed, heavy, WARM)
    assert rest.limits.deceleration < move.limits.deceleration
    assert PLANNER.use(rest, heavy, WARM) <= 1.005


def test_speed_scale_holds():
    slow = MovePlanner(MODEL, PlanSettings(speed_scale=0.3)).plan(HOME, PICK, belief(1.0), WARM)
    _, v, _ = slow.points(np.linspace(0.0, slow.duration, 200))
    share = np.max(np.abs(v) / ROBOT.limits.velocity)
    assert share == pytest.approx(0.3, rel=1e-6)


def test_a_joint_of_unknown_temperature_may_be_cold_or_warm():
    model = read_model(find_shared('ur10e', 'models'))
    unknown, v, still = np.full(6, np.nan), 0.8 * model.robot.limits.velocity, np.zeros(6)
    certain = belief_of_estimate(load_vector(2.0), np.zeros((10, 10)))
    blind = TorqueUse(model, certain, 3.0, unknown)
    for direction in (v, -v):
        for celsius in (5.0, 45.0):
            use = TorqueUse(model, certain, 3.0, np.full(6, celsius))
            assert blind.at(HOME, direction, still) > use.at(HOME, direction, still)
    assert blind.at(HOME, still, still) == TorqueUse(model, certain, 3.0, WARM).at(
        HOME, still, still)


@pytest.mark.parametrize('mass', [0.0, 5.0, 10.0])
def test_braking_ends_at_rest_within_the_torque(mass):
    load = belief(mass)
    move = fast(mass)
    q, v, _ = (x[0] for x in move.points([0.5 * move.duration]))
    use = TorqueUse(MODEL, load, 3.0, WARM)
    brake = braking_trajectory(q, v, use, ROBOT.limits.acceleration)
    assert not brake.velocity[-1].any() and not brake.acceleration[-1].any()
    t = np.linspace(0.0, brake.duration, 200)
    assert use.worst(*brake.sample(t)) <= 1.01
    assert np.all(np.abs(brake.sample(t)[2]) <= ROBOT.limits.acceleration * 1.000001)
    # No detour: each joint only goes on the way it went.
    assert np.all((brake.position[-1] - q) * v >= 0.0)
    np.testing.assert_allclose(brake.sample(0.0)[1], v, atol=1e-12)


def test_braking_with_an_impossible_load_still_stops():
    use = TorqueUse(MODEL, belief(60.0), 3.0, WARM)
    brake = braking_trajectory(FAR_PLACE, np.full(6, 1.0), use, ROBOT.limits.acceleration)
    assert use.worst(brake.position, brake.velocity, brake.acceleration) > 1.0
    assert not brake.velocity[-1].any() and brake.duration <= 2.0
