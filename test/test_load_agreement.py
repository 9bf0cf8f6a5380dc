"""The share of stated variances an estimate of the load suffers from, on data made for it."""

from left_out_helpers import DENSITY, DT, JOINTS, noise, parameters, system_of
import numpy as np
import pytest

from hand_load_estimator.identification import load_agreement
from hand_load_estimator.identification.load_agreement import (LeftOut, share_left_out, share_of,
                                                               slices_of, Window)

N = 250
DRIFT = np.full((JOINTS, 3), 1e-3)


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


@pytest.fixture(scope='module')
def system():
    """Return the System of four recordings of a minute each."""
    return system_of()


def share(system, residual, covariances=None):
    """Return the share of DENSITY, DRIFT and covariances {part: (P, P)} or none."""
    size = system.columns.shape[2]
    covariances = covariances or {part: np.zeros((size, size)) for part in range(4)}
    return share_left_out(system, LeftOut(residual, system.recording, covariances),
                          np.tile(DT / DENSITY, (len(residual), 1)), DRIFT)


@pytest.mark.parametrize('factor', [0.3, 1.0, 4.0])
def test_the_share_of_recordings_left_out_is_that_of_their_noise(system, factor):
    """The largest of three lengths, and a standard error more: a little wide."""
    assert 0.9 * factor < share(system, noise(system, factor)) < 1.5 * factor + 0.1


def test_what_the_model_without_a_recording_was_unsure_of_is_expected_there(system):
    """Links and friction are off in one recording, as the covariance without it says."""
    rng, mean = np.random.default_rng(2), parameters(system.robot)
    wide, none = np.diag((0.2 * mean) ** 2), np.zeros((len(mean), len(mean)))
    off = system.columns @ (0.2 * mean * rng.normal(size=len(mean)))
    residual = noise(system) + off * (system.recording == 2)[:, None]
    known = {part: wide if part == 2 else none for part in range(4)}
    elsewhere = {part: wide if part == 1 else none for part in range(4)}
    assert share(system, residual, known) < 1.5
    for wrong in (elsewhere, None):
        assert share(system, residual, wrong) > 5.0


def test_errors_that_last_show_in_longer_windows(system, monkeypatch):
    """The largest share counts."""
    slow = np.sin(2.0 * np.pi * np.cumsum(system.dt) / 37.0)[:, None] * np.sqrt(DENSITY)
    residual, alone = noise(system, 0.3) + slow, {}
    whole = share(system, residual)
    for length in load_agreement.WINDOWS:
        monkeypatch.setattr(load_agreement, 'WINDOWS', (length,))
        alone[length] = share(system, residual)
    assert whole == max(alone.values()) and whole > 1.3 * min(alone.values())


def test_of_a_few_seconds_the_statement_stands():
    short = system_of(1, 9.0)
    assert share(short, noise(short, 9.0)) == 1.0
