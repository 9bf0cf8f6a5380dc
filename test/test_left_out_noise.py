"""The density and drift that recordings left out show: what is stated does not add to either."""

from copy import copy

from core_helpers import effect_uses
from left_out_helpers import DENSITY, DT, JOINTS, noise, parameters, system_of
import numpy as np
import pytest

from hand_load_estimator.identification import identify, left_out_noise
from hand_load_estimator.identification.left_out_noise import drift_of, noise_left_out
from hand_load_estimator.identification.load_agreement import LeftOut
from hand_load_estimator.identification.regression_system import held_out
from hand_load_estimator.identification.residual_noise import density

# Relative std of all parameters in a recording left out.
DOUBT = 0.2
DRIFT = np.array([0.05, 0.1, 0.1])


@pytest.fixture(scope='module')
def system():
    """Return the System of four recordings of a minute each."""
    return system_of()


def weights(system):
    return np.tile(DT / DENSITY, (len(system.torque), 1))


def made(system, residual):
    """Return the System of the true torque and a residual, and what was known before (prior)."""
    out, robot = copy(system), system.robot
    out.torque = out.columns @ parameters(robot) + residual
    return out, identify.prior(robot, effect_uses(robot), True)


def densities(system, residual):
    """
    Return what is stated, by a fit to the true torque and a residual, over DENSITY.

    By noise_left_out; within the fit; and by what is left of recordings left out alone.
    """
    system, known = made(system, residual)
    x, _ = system.solve(*known, weights(system))
    found, _ = noise_left_out(system, known, weights(system), np.zeros(JOINTS))
    left = held_out(system, *known, weights(system)).residual
    return [result / DENSITY for result in (
        found, *(density(r, weights(system), system.owner, system.dt)
                 for r in (system.residual(x), left)))]


def drifts(system, drift=DRIFT, seed=5):
    """Return the torque (N, n) of offset, level and coefficient that differ from run to run."""
    rng = np.random.default_rng(seed)
    state, velocity = system.drifting
    runs = system.recording.max() + 1
    own = (drift * rng.normal(size=(runs, JOINTS, 3)))[system.recording]
    return own[..., 0] + own[..., 1] * state + own[..., 2] * velocity


def test_with_little_data_what_parameters_do_is_not_counted():
    """Of two recordings of 10 s each is foretold badly by the other; C says so."""
    short = system_of(2, 10.0)
    found, _, left = densities(short, noise(short))
    assert (left > 1.3).any() and (found < 1.25).all() and (found > 0.8).all()


@pytest.mark.parametrize('times', [[1, 1, 1], [3, 0, 0], [0, 3, 0], [0, 0, 6]])
def test_drift_adds_nothing_to_the_density_within_the_fit(system, times):
    """Within the fit it counts, on purpose (doc/method.md)."""
    found, within, left = densities(system, noise(system) + drifts(system, DRIFT * times))
    assert left.max() > 1.15 * found.max()
    assert (found < 1.1 * within).all()


def unlike(system):
    """Return the torque (N, n) of links that differ from recording to recording."""
    rng, x = np.random.default_rng(2), parameters(system.robot)
    wrong = 0.3 * x * rng.normal(size=(4, len(x)))
    wrong[:, 10 * JOINTS:] = 0.0
    return (system.columns * wrong[system.recording][:, None]).sum(axis=2)


def test_what_nothing_states_is_counted(system):
    """Neither drift nor doubt of one arm."""
    found, within, left = densities(system, noise(system) + unlike(system))
    assert (found <= 1.1 * left).all()
    assert found.max() > 1.3 * within[found.argmax()]


def test_of_noise_alone_it_is_that_of_the_fit(system):
    found, within, _ = densities(system, noise(system))
    assert (found >= within).all() and (found < 1.1 * within).all()


def test_c_is_of_fits_by_the_density_within_the_fit(system):
    """Whatever a turn before took for the density: fits that know less would hide an excess."""
    system, known = made(system, noise(system) + unlike(system))
    few, many = (noise_left_out(system, known, factor * weights(system), np.zeros(JOINTS))[0]
                 for factor in (0.1, 1.0))
    np.testing.assert_allclose(few, many, rtol=0.02)


def test_what_drifts_is_in_the_doubt_of_parameters(system):
    """Their squared error over its covariance, beside what it is where drift averages out."""
    squares, plain, found = [], [], []
    for seed in range(6):
        changed, known = made(system, noise(system, seed=seed)
                              + drifts(system, 3.0 * DRIFT, seed))
        _, drift = noise_left_out(changed, known, weights(system), np.zeros(JOINTS))
        found.append(drift / (3.0 * DRIFT))
        unit = np.sqrt(np.diag(known[1]))
        for out, fitted in ((squares, changed.with_drift(drift)), (plain, changed)):
            x, covariance = fitted.solve(*known, weights(system))
            error = (x - parameters(system.robot)) / unit
            out.append(error @ np.linalg.solve(covariance / np.outer(unit, unit), error) / len(x))
    assert np.mean(squares) < 1.5 and np.mean(plain) > 5.0
    size = np.sqrt(np.square(found).mean(axis=(0, 1)))
    assert (size > 0.75).all() and (size < 1.6).all()


def covariance(system, doubt):
    """Return the covariance (P, P) of parameters that are known to a relative std."""
    return np.diag((doubt * parameters(system.robot)) ** 2)


def off(system, runs):
    """Return what the torque (N, n) is off by in some runs, whose parameters are off by DOUBT."""
    x, rng = parameters(system.robot), np.random.default_rng(2)
    wrong = DOUBT * x * rng.normal(size=(4, len(x)))
    return ((system.columns * wrong[system.recording][:, None]).sum(axis=2)
            * np.isin(system.recording, runs)[:, None])


def judged(monkeypatch, system, left_out):
    """Return the density that a LeftOut is said to show, over DENSITY, which is that of a fit."""
    monkeypatch.setattr(left_out_noise, 'held_out', lambda *_: left_out)
    monkeypatch.setattr(left_out_noise, 'density', lambda *_: DENSITY)
    monkeypatch.setattr(left_out_noise, 'drift_of', lambda *_: np.zeros((JOINTS, 3)))
    _, known = made(system, noise(system))
    return noise_left_out(system, known, weights(system), np.zeros(JOINTS))[0] / DENSITY


def test_a_run_is_judged_by_the_doubt_of_the_fit_without_it(monkeypatch, system):
    residual = noise(system) + off(system, [2])

    def by(run):
        return judged(monkeypatch, system, LeftOut(residual, system.recording, {
            k: covariance(system, DOUBT if k == run else 0.0) for k in range(4)}))
    right, wrong = by(2), by(1)
    assert (right < 1.1).all() and (wrong > 1.3 * right).sum() >= 2


def test_blocks_that_only_a_prior_foretells_hide_nothing_elsewhere(monkeypatch, system):
    """Half of the runs are not known of at all, and happen to be as expected."""
    left_out = LeftOut(noise(system, 2.0), system.recording, {
        k: covariance(system, 10.0 if k % 2 else 0.0) for k in range(4)})
    ratio = judged(monkeypatch, system, left_out)
    assert (ratio > 1.7).all() and (ratio < 2.8).all()


def left_out_of(system, residual, doubts):
    """Return the LeftOut of a residual with the relative std of parameters of each part."""
    part = system.recording if len(np.unique(system.recording)) > 1 \
        else np.arange(len(residual)) * 4 // len(residual)
    return LeftOut(residual, part, {k: covariance(system, doubt)
                                    for k, doubt in enumerate(doubts)})


def test_drift_is_found_beside_parameters_in_doubt(system):
    """Both as large as stated: what is left is the drift."""
    residual = noise(system) + drifts(system) + off(system, range(4))
    stated, none = (drift_of(system, left_out_of(system, residual, doubts), weights(system))
                    for doubts in (4 * [DOUBT], 4 * [0.0]))
    alone = drift_of(system, left_out_of(system, noise(system) + drifts(system), 4 * [0.0]),
                     weights(system))
    assert (alone > 0.4 * DRIFT).all() and (alone < 2.0 * DRIFT).all()
    assert (np.abs(stated - alone) < 0.8 * np.abs(none - alone))[:, 1:].mean() > 0.8


def test_a_recording_is_judged_by_the_doubt_of_the_fit_without_it(system):
    residual = noise(system) + off(system, [2])
    right, wrong = (drift_of(system, left_out_of(system, residual, doubts), weights(system))
                    for doubts in ([0.0, 0.0, DOUBT, 0.0], [DOUBT, 0.0, 0.0, 0.0]))
    assert np.square(right[:, 1:]).sum() < 0.3 * np.square(wrong[:, 1:]).sum()


def test_each_part_of_a_single_recording_is_judged_by_its_own_fit():
    single = system_of(1, 120.0)
    second = (np.arange(len(single.torque)) * 4 // len(single.torque) == 1)[:, None]
    residual = noise(single) + second * (single.columns @ (DOUBT * parameters(single.robot)))
    right, wrong = (drift_of(single, left_out_of(single, residual, doubts), weights(single))
                    for doubts in ([0.0, DOUBT, 0.0, 0.0], [DOUBT, 0.0, 0.0, 0.0]))
    assert np.square(right[:, 1:]).sum() < 0.3 * np.square(wrong[:, 1:]).sum()


def test_what_no_other_recording_shows_is_no_drift():
    """Two recordings that move other joints: of each the other knows the prior."""
    apart = np.array([[True, False, True, False], [False, True, False, True]])
    system = system_of(2, 40.0, apart)
    system, known = made(system, noise(system))
    found = drift_of(system, held_out(system, *known, weights(system)), weights(system))
    friction = np.abs(parameters(system.robot)[10 * JOINTS:]).reshape(JOINTS, -1)
    assert (found[:, 1] < 0.1 * friction.max(axis=1)).all()
