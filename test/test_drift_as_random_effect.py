"""Drift in the least squares of identification: as more columns, one set per recording."""

from core_helpers import effect_uses
from left_out_helpers import DENSITY, DT, JOINTS, noise, parameters, system_of
import numpy as np
import pytest

from hand_load_estimator.identification import identify
from hand_load_estimator.identification.regression_system import held_out

# Of the last joint nothing is known to drift.
DRIFT = np.array([0.05, 0.1, 0.1]) * np.array([[1.0], [2.0], [0.5], [0.0]])


def made(runs):
    """Return a System of `runs` recordings, prior mean and covariance, and weights."""
    system = system_of(runs, 20.0)
    # Pieces of one recording need not follow each other.
    system.recording = np.arange(len(system.torque)) // 500 % runs
    system.torque = system.columns @ parameters(system.robot) + 3.0 * noise(system)
    known = identify.prior(system.robot, effect_uses(system.robot), True)
    rng = np.random.default_rng(3)
    return system, known, DT / DENSITY * rng.uniform(0.1, 1.0, system.torque.shape)


def with_columns(system, mean, covariance):
    """Return the System with columns of drift for each recording, and the prior of it."""
    parts = np.unique(system.recording)
    more = np.zeros((*system.torque.shape, 3 * JOINTS * len(parts)))
    state, velocity = system.drifting
    for i, part in enumerate(parts):
        rows = np.flatnonzero(system.recording == part)
        for j in range(JOINTS):
            k = 3 * (i * JOINTS + j)
            more[rows, j, k:k + 3] = np.stack(
                [np.ones(len(rows)), state[rows, j], velocity[rows, j]], axis=1)
    variance = np.r_[np.diag(covariance), np.tile(DRIFT.ravel() ** 2, len(parts))]
    return (system.with_more(more), np.r_[mean, np.zeros(more.shape[2])],
            np.diag(np.maximum(variance, 1e-16)))


def test_it_is_what_columns_of_their_own_would_give():
    system, known, weights = made(3)
    wide, mean, covariance = with_columns(system, *known)
    x, posterior = system.with_drift(DRIFT).solve(*known, weights)
    whole, expected = wide.solve(mean, covariance, weights)
    size = len(x)
    unit = np.sqrt(np.diag(known[1]))
    np.testing.assert_allclose((x - whole[:size]) / unit, 0.0, atol=1e-6)
    np.testing.assert_allclose((posterior - expected[:size, :size]) / np.outer(unit, unit), 0.0,
                               atol=1e-6)


def test_so_it_is_of_what_is_left_out():
    system, known, weights = made(3)
    wide, mean, covariance = with_columns(system, *known)
    found = held_out(system.with_drift(DRIFT), *known, weights)
    expected = held_out(wide, mean, covariance, weights)
    np.testing.assert_allclose(found.residual, expected.residual, atol=1e-5)
    unit = np.sqrt(np.diag(known[1]))
    for part, covariance in found.covariances.items():
        own = expected.covariances[part][:len(unit), :len(unit)]
        np.testing.assert_allclose((covariance - own) / np.outer(unit, unit), 0.0, atol=1e-6)


@pytest.mark.parametrize('runs, drift', [(3, np.zeros((JOINTS, 3))), (1, DRIFT)])
def test_where_nothing_drifts_it_is_the_plain_solution(runs, drift):
    """Nor does anything between the recordings where there is one."""
    system, known, weights = made(runs)
    for a, b in zip(system.with_drift(drift).solve(*known, weights),
                    system.solve(*known, weights)):
        np.testing.assert_array_equal(a, b)
