"""Solving with small positive matrices."""

import numpy as np
import pytest

from hand_load_estimator.estimators.positive_solve import positive_solve, unit


@pytest.mark.parametrize('right', [(30,), (30, 11)])
def test_it_is_numpys_solution(right):
    rng = np.random.default_rng(1)
    root = rng.normal(size=(60, 30))
    matrix, right = root.T @ root, rng.normal(size=right)
    before = matrix.copy(), right.copy()
    np.testing.assert_allclose(positive_solve(matrix, right), np.linalg.solve(matrix, right),
                               rtol=1e-11, atol=1e-13)
    np.testing.assert_array_equal(matrix, before[0])
    np.testing.assert_array_equal(right, before[1])


def test_what_is_not_positive_is_solved_and_what_is_singular_refused():
    np.testing.assert_allclose(positive_solve(np.diag([2.0, -4.0]), np.ones(2)), [0.5, -0.25])
    with pytest.raises(np.linalg.LinAlgError):
        positive_solve(np.zeros((2, 2)), np.ones(2))


def test_the_identity_cannot_be_written_to():
    np.testing.assert_array_equal(unit(3), np.eye(3))
    with pytest.raises(ValueError):
        unit(3)[0, 0] = 2.0
