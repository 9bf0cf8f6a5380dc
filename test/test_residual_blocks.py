"""Blocks: sums over blocks score a hypothesis exactly as fitting without each fold would."""

import numpy as np
import pytest

from hand_load_estimator.residual.measured.blocks import Blocks

ROWS, JOINTS = 240, 3
STARTS = np.array([0, 30, 75, 100, 140, 190])
FOLDS = np.array([0, 1, 2, 0, 1, 2])


@pytest.fixture(scope='module')
def data():
    """Return residual, weights (N, n), nuisances and columns of random numbers."""
    rng = np.random.default_rng(4)
    nuisances = [rng.normal(size=(ROWS, k)) for k in (2, 0, 1)]
    columns = {0: rng.normal(size=(ROWS, 2)), 2: rng.normal(size=(ROWS, 2))}
    residual = rng.normal(size=(ROWS, JOINTS))
    for j, c in columns.items():
        residual[:, j] += c @ [0.4, -0.7]
    for j, d in enumerate(nuisances):
        residual[:, j] += d.sum(axis=1)
    weights = rng.uniform(0.0, 2.0, (ROWS, JOINTS))
    return residual, weights, nuisances, columns


def blocks_of(data):
    residual, weights, nuisances, _ = data
    return Blocks(residual, weights, nuisances, STARTS, FOLDS)


def fold_of_rows():
    return np.repeat(FOLDS, np.diff(np.append(STARTS, ROWS)))


def ridge(data, columns, rows):
    """
    Return (theta, residual (N, n) after the fit, information) by plain least squares on rows.

    Unknowns: theta shared by all joints of columns, then each joint's nuisances.
    """
    residual, weights, nuisances, _ = data
    k = next(iter(columns.values())).shape[1] if columns else 0
    width = k + sum(d.shape[1] for d in nuisances)
    big = np.zeros((ROWS, JOINTS, width))
    place = k
    for j, d in enumerate(nuisances):
        if j in columns:
            big[:, j, :k] = columns[j]
        big[:, j, place:place + d.shape[1]] = d
        place += d.shape[1]
    w, y = weights[rows].ravel(), residual[rows].ravel()
    matrix = big[rows].reshape(-1, width)
    information = (matrix * w[:, None]).T @ matrix + np.eye(width)
    solution = np.linalg.solve(information, (matrix * w[:, None]).T @ y)
    return solution[:k], residual - big @ solution, information


def gains(data, columns):
    """Return the held-out log-likelihood gained (N, n) per row and joint, fitted directly."""
    folds, weights = fold_of_rows(), data[1]
    out = np.zeros((ROWS, JOINTS))
    for fold in np.unique(folds):
        train, test = folds != fold, folds == fold
        without, beside = (ridge(data, c, train)[1] for c in ({}, columns))
        out[test] = 0.5 * (weights * (without ** 2 - beside ** 2))[test]
    return out


@pytest.mark.parametrize('joints', [(0,), (2,), (0, 2)])
def test_a_score_is_that_of_leaving_folds_out(data, joints):
    columns = {j: data[3][j] for j in joints}
    score, wanted = blocks_of(data).evaluate(columns), gains(data, columns)
    by_block = np.add.reduceat(wanted.sum(axis=1), STARTS)
    np.testing.assert_allclose(score.by_block, by_block, rtol=1e-8, atol=1e-9)
    assert score.gain == pytest.approx(by_block.sum())
    assert score.std == pytest.approx(np.sqrt(len(STARTS)) * by_block.std())
    assert score.by_joint == pytest.approx({j: wanted[:, j].sum() for j in joints})
    # Held-out gains are not those of the fit: the test would pass on any fold rule otherwise.
    all_rows = np.ones(ROWS, dtype=bool)
    fitted = 0.5 * (data[1] * (ridge(data, {}, all_rows)[1] ** 2
                               - ridge(data, columns, all_rows)[1] ** 2)).sum()
    assert abs(fitted - score.gain) > 0.01 * abs(fitted)


def test_the_fit_on_all_blocks_is_ridge_regression(data):
    """One theta for both joints, with the covariance it has beside the nuisances."""
    columns = data[3]
    score = blocks_of(data).evaluate(columns)
    theta, _, information = ridge(data, columns, np.ones(ROWS, dtype=bool))
    np.testing.assert_allclose(score.theta, theta, rtol=1e-9)
    np.testing.assert_allclose(score.covariance, np.linalg.inv(information)[:2, :2], rtol=1e-9)


def test_what_is_left_over_is_the_residual_after_its_nuisances(data):
    blocks = blocks_of(data)
    _, left, _ = ridge(data, {}, np.ones(ROWS, dtype=bool))
    for j in range(JOINTS):
        np.testing.assert_allclose(blocks.left_over(j), left[:, j], rtol=1e-9, atol=1e-12)


def test_columns_added_are_nuisances_from_then_on(data):
    residual, weights, nuisances, columns = data
    later = blocks_of(data)
    before = later.evaluate({0: columns[0]})
    later.add({0: columns[0]})
    at_once = Blocks(residual, weights, [np.hstack([nuisances[0], columns[0]]), *nuisances[1:]],
                     STARTS, FOLDS)
    for blocks in (later, at_once):
        score = blocks.evaluate({0: columns[0][:, :1], 1: columns[2][:, :1]})
        np.testing.assert_allclose(score.by_block, at_once.evaluate(
            {0: columns[0][:, :1], 1: columns[2][:, :1]}).by_block)
    assert before.gain > 20.0
    # The same columns once more gain nothing.
    assert later.evaluate({0: columns[0]}).gain < 0.05 * before.gain
    np.testing.assert_allclose(later.left_over(0), at_once.left_over(0))
    np.testing.assert_allclose(later.left_over(1), blocks_of(data).left_over(1))


def test_rows_of_no_weight_count_for_nothing(data):
    residual, weights, nuisances, columns = data
    masked = weights.copy()
    masked[::2] = 0.0
    spoilt = residual.copy()
    spoilt[::2] = 1e3
    one, two = (Blocks(r, masked, nuisances, STARTS, FOLDS).evaluate(columns)
                for r in (residual, spoilt))
    np.testing.assert_allclose(one.by_block, two.by_block, rtol=1e-6, atol=1e-6)


def test_columns_of_chance_gain_nothing():
    rng = np.random.default_rng(0)
    values = []
    for _ in range(40):
        blocks = Blocks(rng.normal(size=(ROWS, 1)), np.ones((ROWS, 1)), [np.zeros((ROWS, 0))],
                        STARTS, FOLDS)
        values.append(blocks.evaluate({0: rng.normal(size=(ROWS, 2))}).gain)
    # Each wrong parameter costs about half a nat times train and test over train.
    assert -3.0 < np.mean(values) < 0.0 and np.max(values) < 5.0


def test_what_is_there_is_found_within_its_deviation():
    rng = np.random.default_rng(1)
    columns, truth = rng.normal(size=(ROWS, 2)), np.array([0.5, -0.3])
    residual = (columns @ truth + 0.5 * rng.normal(size=ROWS))[:, None]
    blocks = Blocks(residual, np.full((ROWS, 1), 4.0), [np.zeros((ROWS, 0))], STARTS, FOLDS)
    score = blocks.evaluate({0: columns})
    std = np.sqrt(np.diag(score.covariance))
    np.testing.assert_allclose(std, 0.5 / np.sqrt(ROWS), rtol=0.15)
    assert (np.abs(score.theta - truth) < 3.5 * std).all()
    assert score.gain > 3.0 * score.std > 0.0


def test_columns_beside_leave_the_blocks_as_they_are(data):
    columns = data[3]
    blocks, added = blocks_of(data), blocks_of(data)
    before = blocks.evaluate({1: columns[0]}).gain
    beside = blocks.beside(columns)
    added.add(columns)
    asked = {0: columns[0][:, :1] ** 2, 1: columns[0][:, :1]}
    assert beside.evaluate(asked).gain == added.evaluate(asked).gain \
        != blocks.evaluate(asked).gain
    assert blocks.evaluate({1: columns[0]}).gain == before
