"""A changed load is noticed soon; the same load is not mistaken for another."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
from plant_helpers import ur10e
import pytest

from hand_load_estimator.estimators import change_windows
from hand_load_estimator.estimators.change import (EVIDENCE, expected_ahead, log_bayes_factor,
                                                   LONG, PIECE, RecentData, strongest_joint)
from hand_load_estimator.estimators.information import Information
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.estimators.model_trust import ModelTrust
from hand_load_estimator.estimators.regression import LoadRegression
from hand_load_estimator.load import LoadParameters

SECONDS = 1.2  # within which a change of 2 kg must be noticed while the arm moves


def run(before, after=None, at=3.0, seconds=6.0, seed=0, rest=0.6):
    """Return the estimates and the pipeline of a run whose load changes."""
    model = exact_model('ur10e')
    pipeline = warm(pipeline_of(model))
    stream = messages(model, before, seconds, seed=seed, rest=rest,
                      change=(at, after) if after else None)
    return feed(pipeline, stream), pipeline


@pytest.mark.parametrize('before, after', [
    (LoadParameters(), block(2.0)), (block(2.0), LoadParameters()), (block(3.0), block(5.0)),
    (block(5.0), block(3.0))])
def test_a_change_of_two_kilograms_is_noticed_and_the_new_load_found(before, after):
    estimates, pipeline = run(before, after)
    noticed = [e.stamp - 103.0 for e in estimates if e.load_id > 0]
    assert noticed and 0.0 < noticed[0] < SECONDS
    assert any(e.status == 'LOAD_CHANGED' for e in estimates)
    first = next(e for e in estimates if e.load_id > 0)
    assert first.status == 'LOAD_CHANGED'
    assert pipeline.load_id == 1, 'one change is one change'
    last = estimates[-1]
    assert abs(last.mean[0] - after.mass) < max(3.0 * last.std[0], 0.03)
    old = [e for e in estimates if e.stamp < 103.0][-1]
    assert abs(old.mean[0] - before.mass) < max(3.0 * old.std[0], 0.03)


@pytest.mark.parametrize('at', [2.55, 2.85, 3.15, 3.45])
def test_a_large_change_in_motion_is_noticed_at_once_and_counted_once(at):
    """What the motion filter still shows of the old load is no third one."""
    estimates, pipeline = run(block(9.9), LoadParameters(), at=at, seconds=5.0)
    seen = next(e.stamp for e in estimates if e.load_id > 0)
    assert seen - 100.0 - at < 0.2 and pipeline.load_id == 1
    after = [e for e in estimates if e.stamp > seen + 0.3]
    assert max(abs(e.mean[0]) / e.std[0] for e in after) < 4.0


@pytest.mark.parametrize('seed', range(6))
def test_the_same_load_is_the_same_load(seed):
    estimates, pipeline = run(block([0.0, 2.0, 9.0][seed % 3]) if seed % 3 else LoadParameters(),
                              seed=seed, seconds=5.0)
    assert pipeline.load_id == 0
    assert not any(e.status == 'LOAD_CHANGED' for e in estimates)


def test_standing_with_the_same_load_is_no_change():
    for load in (LoadParameters(), block(9.0)):
        _, pipeline = run(load, seconds=3.0, rest=9.0)
        assert pipeline.load_id == 0


def test_a_large_change_while_standing_is_noticed_at_once_and_counted_once():
    """More than friction can hide: ten kilograms on an arm that stands from 0 to 4 s."""
    estimates, pipeline = run(LoadParameters(), block(10.0), at=2.0, seconds=7.0, rest=4.0)
    noticed = [e.stamp - 102.0 for e in estimates if e.load_id > 0]
    assert noticed and 0.0 < noticed[0] < 1.0 and pipeline.load_id == 1
    last = estimates[-1]
    assert abs(last.mean[0] - 10.0) < 3.5 * last.std[0] and last.std[0] < 0.1


def test_a_small_change_while_standing_is_found_when_the_arm_moves():
    """Friction hides it at rest; what was believed before must not be mixed in later."""
    model = exact_model('ur10e')
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, block(2.0), 4.0))
    estimates = feed(pipeline, [replace(m, stamp=m.stamp + 4.5) for m in
                                messages(model, block(3.0), 5.0, seed=1, rest=1.0)])
    assert not any(e.load_id for e in estimates if e.stamp < 105.5)
    assert pipeline.load_id == 1
    last = estimates[-1]
    assert abs(last.mean[0] - 3.0) < 3.5 * last.std[0] and last.std[0] < 0.1


@pytest.mark.parametrize('at', [3.0, 3.05, 3.2])
@pytest.mark.parametrize('before, after', [(0.0, 0.5), (2.0, 2.5), (2.0, 6.0)])
def test_no_data_of_the_old_load_is_left_in_the_new_ones_estimate(before, after, at):
    """
    Once a change is noticed, the interval must hold the new load and not a mixture.

    A small change is noticed late, when much of the recent data still comes from the old load.
    """
    loads = [block(mass) if mass else LoadParameters() for mass in (before, after)]
    estimates, pipeline = run(*loads, at=at, seconds=6.0)
    assert pipeline.load_id > 0
    noticed = next(e.stamp for e in estimates if e.load_id > 0)
    late = [e for e in estimates if e.stamp > noticed + 0.5]
    off = np.array([abs(e.mean[0] - after) / e.std[0] for e in late])
    assert np.mean(off < 3.0) > 0.95, f'off by {off.max():.1f} standard deviations'
    assert late[-1].std[0] < 0.1


def test_what_slips_weighs_what_it_weighed():
    """Before motion tells anything of the new place, the load before is the best guess."""
    slipped = replace(block(6.0), com=block(6.0).com + [0.05, 0.0, 0.0])
    estimates, pipeline = run(block(6.0), slipped, at=3.0)
    assert pipeline.load_id == 1
    after = [e for e in estimates if e.load_id == 1]
    assert max(abs(e.mean[0] - 6.0) for e in after) < 0.2
    assert after[0].std[0] > 2.0, 'it may be any other as well'
    np.testing.assert_allclose(after[-1].mean[1:4], slipped.com, atol=3e-3)


def information(rng, load, count, extra=0):
    robot, out = ur10e(), Information(6, extra)
    for _ in range(count):
        q, v, a = rng.uniform(-1.5, 1.5, (3, 6))
        k = np.hstack([robot.load_regressor(q, v, a), rng.normal(size=(6, extra))])
        torque = k[:, :10] @ load.to_products() + rng.normal(size=6)
        out.add_rows(k, torque, np.ones(6))
    return out


def dense_factor(recent, mean, covariance, change):
    """Return the log Bayes factor from two normals of z, written out."""
    z = recent.vector - recent.matrix @ mean
    noise = recent.matrix + recent.matrix @ covariance @ recent.matrix
    shift = recent.matrix[:, :10] @ change @ recent.matrix[:10]

    def log_normal(s):
        return -0.5 * (z @ np.linalg.solve(s, z) + np.linalg.slogdet(s)[1])

    return log_normal(noise + shift) - log_normal(noise)


@pytest.mark.parametrize('extra', [0, 3])
@pytest.mark.parametrize('mass', [2.0, 4.0])
def test_evidence_is_the_ratio_of_two_normals(extra, mass):
    rng = np.random.default_rng(1)
    d = 10 + extra
    recent = information(rng, block(mass), 40, extra)
    mean = np.concatenate([block(2.0).to_products(), np.zeros(extra)])
    root = 0.05 * rng.normal(size=(d, d))
    covariance, change = root @ root.T, np.diag(np.linspace(0.5, 0.02, 10) ** 2)
    got = log_bayes_factor(recent, mean, np.linalg.inv(covariance), change)
    assert got == pytest.approx(dense_factor(recent, mean, covariance, change), rel=1e-5,
                                abs=1e-5)


@pytest.mark.parametrize('mass, jump', [(2.0, 0.0), (2.0, 3.0), (4.0, 0.0), (9.0, 0.0)])
def test_evidence_is_never_more_than_half_of_what_the_older_belief_leaves(mass, jump):
    """So that nothing is missed where that is too little, and no evidence is asked for."""
    change = np.diag([4.0] + [0.3] * 3 + [0.05] * 6) ** 2
    for seed in range(5):
        rng = np.random.default_rng(seed)
        recent = drifting(rng, block(mass), jump, rows=int(rng.integers(1, 40)))
        mean = np.concatenate([block(2.0).to_products(), 0.1 * rng.normal(size=18)])
        precision = np.diag(rng.uniform(1.0, 1e4, 28))
        bound = 0.5 * recent.left_by(mean)
        assert log_bayes_factor(recent, mean, precision, change) < bound
        assert strongest_joint(recent, mean, precision, 6) < bound


def test_what_unknowns_leave_is_the_weighted_square_of_the_rest():
    rng, sums, parts = np.random.default_rng(7), Information(6, 2), []
    unknowns, square = rng.normal(size=12), 0.0
    for _ in range(9):
        columns, torque, weights = (rng.normal(size=(6, 12)), rng.normal(size=6),
                                    rng.uniform(0.1, 9.0, 6))
        parts.append(Information(6, 2))
        parts[-1].add_rows(columns, torque, weights)
        sums.add_rows(columns, torque, weights)
        square += weights @ (torque - columns @ unknowns) ** 2
    assert sums.left_by(unknowns) == pytest.approx(square, rel=1e-9)
    joined = Information(6, 2)
    joined.add(parts[0].plus(parts[1]))
    joined.take_off(parts[0], 0.5)
    joined.scale(2.0)
    assert joined.left_by(unknowns) == pytest.approx(
        parts[0].left_by(unknowns) + 2.0 * parts[1].left_by(unknowns), rel=1e-9)


def test_evidence_speaks_for_the_same_load_and_against_another():
    rng = np.random.default_rng(2)
    precision, change = 1e6 * np.eye(10), np.diag([4.0] + [0.2] * 3 + [0.02] * 6)
    same = log_bayes_factor(information(rng, block(3.0), 30), block(3.0).to_products(),
                            precision, change)
    other = log_bayes_factor(information(rng, block(5.0), 30), block(3.0).to_products(),
                             precision, change)
    assert same < 0.0 and other > EVIDENCE


def drifting(rng, load, jump=0.0, rows=40, weights=np.ones(6), one_pose=False):
    """Return Information of rows: load, then offset, Coulomb and viscous drift of six joints."""
    robot, out = exact_model('ur10e').robot, Information(0, 18)
    for q, v, a in rng.uniform(-1.5, 1.5, (rows, 3, 6)) * (0.02 if one_pose else 1.0) + one_pose:
        drifts = [np.diag(0.2 * part) for part in (np.ones(6), np.sign(v), v)]
        columns = np.hstack([robot.load_regressor(q, v, a), *drifts])
        torque = columns[:, :10] @ load.to_products() + jump + rng.normal(size=6)
        out.add_rows(columns, torque, weights)
    return out


@pytest.mark.parametrize('seed', range(4))
def test_how_far_a_load_is_ahead_of_a_joint_is_known_before(seed):
    """It is as far as it turns out to be, and where one joint tells hardly at all."""
    rng, change = np.random.default_rng(seed), np.diag([4.0] + [0.3] * 3 + [0.05] * 6) ** 2
    older = drifting(rng, block(3.0), rows=300)
    precision = older.matrix + np.diag([1e-6] * 10 + [1.0] * 18)
    mean = np.linalg.solve(precision, older.vector)
    for weights, one_pose in ((np.ones(6), False), (np.ones(6), True), (np.eye(6)[1], True)):
        recent = drifting(rng, block(9.0), weights=weights, one_pose=one_pose)
        expected = expected_ahead(recent, mean, precision, change, 6)
        evidence = log_bayes_factor(recent, mean, precision, change)
        ahead = evidence - strongest_joint(recent, mean, precision, 6)
        assert evidence > 2.0 * EVIDENCE and abs(ahead - expected) < 0.05 * abs(ahead) + 3.0
        assert expected > 4.0 * EVIDENCE if weights.all() else expected < EVIDENCE


@pytest.mark.parametrize('joint', range(1, 6))
@pytest.mark.parametrize('changed', [True, False])
def test_a_joint_that_jumps_is_told_from_a_load_that_changes(joint, changed):
    rng, change = np.random.default_rng(joint), np.diag([4.0] + [0.3] * 3 + [0.05] * 6) ** 2
    older = drifting(rng, block(3.0), rows=300)
    precision = older.matrix + np.diag([1e-6] * 10 + [1.0] * 18)
    mean = np.linalg.solve(precision, older.vector)
    jump = 0.0 if changed else 5.0 * np.eye(6)[joint]
    recent = drifting(rng, block(4.5 if changed else 3.0), jump)
    of_load = log_bayes_factor(recent, mean, precision, change)
    of_joint = strongest_joint(recent, mean, precision, 6)
    assert max(of_load, of_joint) > EVIDENCE
    assert (of_load > of_joint + EVIDENCE) == changed


def kicked(joint, seconds=6.0, at=3.0):
    """Return messages of an arm with 3 kg, one of whose joints drags by 2 % of its limit since."""
    model = exact_model('ur10e')
    drag = 0.02 * model.robot.limits.torque * np.eye(6)[joint]
    return [m if m.stamp < 100.0 + at else replace(m, effort=m.effort + drag * np.tanh(
        m.velocity / 0.02)) for m in messages(model, block(3.0), seconds)]


@pytest.mark.parametrize('joint', [1, 2, 3])
def test_a_joint_that_begins_to_drag_is_no_other_load(joint, monkeypatch):
    """Where the model has not foretold the torques."""
    monkeypatch.setattr(ModelTrust, 'foretold_before', lambda self: False)
    pipeline = warm(pipeline_of(exact_model('ur10e')))
    feed(pipeline, kicked(joint))
    assert pipeline.load_id == 0
    monkeypatch.setattr(change_windows, 'strongest_joint', lambda *arguments: -np.inf)
    pipeline = warm(pipeline_of(exact_model('ur10e')))
    feed(pipeline, kicked(joint))
    assert pipeline.load_id > 0, 'nothing to be told apart here'


def test_recent_data_keep_every_row_once():
    rng, whole = np.random.default_rng(3), Information(6, 2)
    recent, ends = RecentData(6, 2, memory=1e12), 0
    for k in range(120):
        columns, torque = rng.normal(size=(6, 12)), rng.normal(size=6)
        ends += recent.add(columns, torque, np.ones(6), 0.02 if k % 4 else 0.0)
        whole.add_rows(columns, torque, np.ones(6))
        if k % 17 == 0:
            for name in ('matrix', 'vector', 'by_joint'):
                np.testing.assert_allclose(getattr(recent.total(), name), getattr(whole, name),
                                           atol=1e-8)
    assert ends == pytest.approx(90 * 0.02 / PIECE, abs=1) and len(recent.pieces) == LONG + 1
    older, newest = recent.split(3)
    np.testing.assert_allclose(newest.vector, sum(p.vector for p in list(recent.pieces)[-3:]),
                               atol=1e-8)
    np.testing.assert_allclose(older.matrix + newest.matrix, sum(
        p.matrix for p in recent.pieces) + recent.older.matrix, atol=1e-6)


def test_stamps_that_jitter_make_pieces_of_the_same_length():
    rng, recent, ends = np.random.default_rng(6), RecentData(6, 0, memory=1e12), 0
    for moved in 0.02 + rng.uniform(-1e-4, 1e-4, 3000):
        ends += recent.add(np.zeros((6, 10)), np.zeros(6), np.ones(6), moved)
    assert ends == pytest.approx(60.0 / PIECE, rel=0.01)


def test_old_data_fade_with_the_stated_memory():
    recent, ones = RecentData(6, 0, memory=10.0), np.ones((6, 10))
    pieces = LONG + 101
    for _ in range(pieces):
        recent.add(ones, np.zeros(6), np.ones(6), PIECE)
    faded = np.sum(np.exp(-PIECE / 10.0 * np.arange(100)))
    assert recent.total().matrix[0, 0] == pytest.approx(6.0 * (LONG + 1 + faded), rel=1e-6)


def test_the_kept_sum_is_the_sum_of_the_pieces():
    rng, recent = np.random.default_rng(4), RecentData(6, 2, memory=5.0)
    for _ in range(400):
        recent.add(rng.normal(size=(6, 12)), rng.normal(size=6), np.ones(6), 0.04)
    recent.add(np.zeros((6, 12)), np.zeros(6), np.ones(6), PIECE)
    for name in ('matrix', 'vector', 'by_joint'):
        parts = [getattr(part, name) for part in (recent.older, *recent.pieces)]
        np.testing.assert_allclose(getattr(recent.total(), name), np.sum(parts, axis=0),
                                   rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize('weight', [60.0, 75.0, 1000.0])
def test_what_is_taken_back_holds_nothing_of_the_other_load(weight):
    """The less a change stands out, the further back it lies when it is seen."""
    rng, regression = np.random.default_rng(5), LoadRegression(load_prior(ur10e()), 6, 18)
    held, other = (block(mass).to_products() for mass in (3.0, 3.12))

    def take(products, begin, seconds):
        for stamp in np.arange(begin, begin + seconds, 0.02):
            columns = rng.normal(size=(6, 28))
            regression.add(SimpleNamespace(stamp=stamp, dt=0.02, v=np.ones(6)), columns,
                           columns[:, :10] @ products, np.full(6, weight), True)
            regression.look_for_change()
            if regression.changes:
                return stamp
        return begin + seconds

    begun = take(held, 0.0, 20.0)
    assert regression.changes == 0
    before = regression.update_posterior().mean[0]
    seen = take(other, begun, 5.0)
    assert regression.changes == 1
    assert regression.changed_pieces * PIECE == pytest.approx(seen - begun + PIECE, abs=PIECE)
    assert regression.take_back(seen)
    assert abs(regression.posterior.mean[0] - before) < 1e-5
    assert regression.expected.mean[0] == load_prior(ur10e()).mean[0]


@pytest.fixture
def changed():
    """Return a LoadRegression that has seen three kilograms become six, at full evidence."""
    rng, regression = np.random.default_rng(6), LoadRegression(load_prior(ur10e()), 6, 18)
    for stamp in np.arange(0.0, 4.0, 0.02):
        products = block(3.0 if stamp < 2.0 else 6.0).to_products()
        columns = rng.normal(size=(6, 28))
        regression.add(SimpleNamespace(stamp=stamp, dt=0.02, v=np.ones(6)), columns,
                       columns[:, :10] @ products, np.full(6, 100.0), True)
        regression.look_for_change()
        if regression.changes:
            return regression
    raise AssertionError('six kilograms were not seen')


def test_another_load_is_expected_around_the_one_before(changed):
    first, expected = load_prior(ur10e()), changed.expected
    np.testing.assert_allclose(expected.mean[:4], [3.0, *block(3.0).com], atol=0.02)
    np.testing.assert_allclose(expected.std, np.hypot(first.std, expected.mean - first.mean))
    assert changed.update_posterior().mean[0] == pytest.approx(expected.mean[0])
    # Of no third one it is known that the second was expected somewhere.
    changed.begin_anew(3.0, 0)
    np.testing.assert_allclose(changed.expected.std, np.hypot(
        first.std, changed.expected.mean - first.mean))


def test_what_is_expected_of_another_load_survives_a_restart(changed):
    """An arm that was gripping when the node was killed."""
    again = LoadRegression(load_prior(ur10e()), 6, 18)
    again.restore(changed.state())
    np.testing.assert_array_equal(again.expected.mean, changed.expected.mean)
    np.testing.assert_array_equal(again.expected.std, changed.expected.std)
    assert abs(again.posterior.mean[0] - 3.0) < 0.1


def test_no_load_comes_back_into_another_run(changed):
    state = LoadRegression(load_prior(ur10e()), 6, 18).state()
    assert changed.last_change is not None
    changed.restore(state)
    assert not changed.take_back(changed.last_change + 0.1)
    assert changed.posterior.mean[0] == pytest.approx(load_prior(ur10e()).mean[0])


@pytest.mark.parametrize('end', [LoadRegression.forget, LoadRegression.tare])
def test_who_forgets_the_load_expects_any(changed, end):
    end(changed)
    first = load_prior(ur10e())
    np.testing.assert_array_equal(changed.expected.mean, first.mean)
    np.testing.assert_array_equal(changed.expected.std, first.std)
