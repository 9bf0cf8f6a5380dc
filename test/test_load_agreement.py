"""The share of stated variances an estimate of the load suffers from, on data made for it."""

import numpy as np
import pytest

from hand_load_estimator.load_agreement import share_of, slices_of, Window

N, JOINTS, DT = 250, 4, 0.02
DENSITY = np.array([0.04, 0.02, 0.01, 0.01])


def windows(factor, uncertainty=0.0, count=60):
    """Return Windows whose residual has `factor` times the stated variances."""
    rng = np.random.default_rng(3)
    out = []
    for _ in range(count):
        load = rng.normal(size=(N, JOINTS, 10)) * 10.0 ** np.linspace(0.0, -3.0, 10)
        uncertain = uncertainty * rng.normal(size=(N, JOINTS, 3))
        stuck = rng.uniform(0.0, 0.05, (N, JOINTS))
        noise = rng.normal(size=(N, JOINTS)) * np.sqrt((DENSITY + stuck) / DT)
        residual = np.sqrt(factor) * (noise + uncertain @ rng.normal(size=3))
        out.append(Window(load, uncertain, residual, DT / (DENSITY + stuck)))
    return out


@pytest.mark.parametrize('factor', [0.3, 1.0, 4.0])
@pytest.mark.parametrize('uncertainty', [0.0, 0.2])
def test_it_is_the_ratio_of_true_to_stated_variance(factor, uncertainty):
    squares = [w.squared_error() for w in windows(factor, uncertainty)]
    assert share_of(squares) == pytest.approx(factor, rel=0.15)


@pytest.mark.parametrize('rank', [1, 4, 8])
def test_directions_nothing_is_told_of_do_not_count(rank):
    """A standing arm or one of few axes knows less; what it knows is judged alone."""
    rng = np.random.default_rng(5)
    blind = rng.normal(size=(rank, 10)) * 10.0 ** np.linspace(0.0, -3.0, 10)
    squares = []
    for _ in range(80):
        load = rng.normal(size=(N, JOINTS, rank)) @ blind
        noise = rng.normal(size=(N, JOINTS)) * np.sqrt(DENSITY / DT)
        squares.append(Window(load, np.zeros((N, JOINTS, 1)), noise,
                              np.tile(DT / DENSITY, (N, 1))).squared_error())
    assert np.mean(squares) == pytest.approx(1.0, rel=0.4 / np.sqrt(rank))


def test_a_window_that_tells_nothing_is_left_out():
    nothing = Window(np.zeros((N, JOINTS, 10)), np.zeros((N, JOINTS, 1)), np.ones((N, JOINTS)),
                     np.ones((N, JOINTS))).squared_error()
    assert np.isnan(nothing) and share_of([nothing, 3.0]) == 2.0


def test_without_data_the_statement_stands():
    assert share_of([]) == 1.0


def test_one_window_tells_half():
    assert share_of([0.0]) == 0.5


def test_windows_lie_within_parts_and_leave_rests_out():
    dt = np.full(1300, DT)
    part = np.r_[np.zeros(600, int), np.ones(100, int), np.full(600, 2)]
    found = slices_of(dt, part, 5.0)
    assert [(s.start, s.stop) for s in found] == [(0, 249), (249, 499), (700, 949), (949, 1199)]
    for rows in found:
        assert len(set(part[rows])) == 1
        assert dt[rows].sum() == pytest.approx(5.0, abs=2 * DT)
