"""The density and the drift that recordings left out show: parameters' doubt counts once."""

from core_helpers import effect_uses, four_axes, true_parameters
from effect_helpers import waves
import numpy as np
import pytest

from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.identification.load_agreement import LeftOut
from hand_load_estimator.identification.regression_system import System
from hand_load_estimator.identification.residual_noise import density_left_out, drift_of

JOINTS, DT, RUNS = 4, 0.02, 4
DENSITY = np.array([0.04, 0.02, 0.01, 0.01])
# Relative std of all parameters in a recording left out.
DOUBT = 0.2


@pytest.fixture(scope='module')
def system():
    """Return the System of RUNS recordings of a minute each."""
    robot, rng = four_axes(), np.random.default_rng(7)
    uses, motions = effect_uses(robot), [waves(robot, rng, 60.0, 25.0) for _ in range(RUNS)]
    return System(robot, uses, [Evidence(f'run {k}', motion, np.zeros_like(motion.q))
                                for k, motion in enumerate(motions)],
                  true_parameters(robot, uses))


def noise(system, factor=1.0):
    """Return a residual (N, n) with `factor` times the variance that DENSITY states."""
    rng = np.random.default_rng(11)
    return rng.normal(size=system.torque.shape) * np.sqrt(factor * DENSITY / DT)


def parameters(system):
    return true_parameters(system.robot, effect_uses(system.robot))


def off(system):
    """Return what the torque is off by (N, n) where each run's parameters are off by DOUBT."""
    rng, x = np.random.default_rng(2), parameters(system)
    wrong = DOUBT * x * rng.normal(size=(RUNS, len(x)))
    return (system.columns * wrong[system.recording][:, None]).sum(axis=2)


def left_out(system, residual, doubt):
    """Return the LeftOut of a residual, each run found with such a relative std."""
    covariance = np.diag((doubt * parameters(system)) ** 2)
    return LeftOut(residual, system.recording, {run: covariance for run in range(RUNS)})


def weights(system):
    return np.tile(DT / DENSITY, (len(system.torque), 1))


def density_ratio(system, residual, doubt):
    return density_left_out(DENSITY, system, left_out(system, residual, doubt),
                            weights(system)) / DENSITY


@pytest.mark.parametrize('factor', [1.0, 4.0])
def test_the_density_is_that_of_noise_where_parameters_are_known(system, factor):
    """The largest of four lengths of block, so a little more."""
    ratio = density_ratio(system, noise(system, factor), 0.0)
    assert (ratio >= factor).all() and (ratio < 1.25 * factor).all()


def test_it_is_never_less_than_within_the_fit(system):
    assert (density_ratio(system, noise(system, 0.2), 0.0) == 1.0).all()


def test_what_parameters_do_that_are_in_doubt_is_not_counted_again(system):
    """Their covariance states it; whoever adds both would state it twice."""
    residual = noise(system) + off(system)
    known, unknown = (density_ratio(system, residual, doubt) for doubt in (DOUBT, 0.0))
    assert (known < 1.25).all() and (unknown > 1.5 * known).all()


def test_a_run_is_judged_by_the_doubt_of_the_fit_without_it(system):
    only_one = noise(system) + off(system) * (system.recording == 2)[:, None]
    wide, none = (left_out(system, only_one, doubt).covariances[0] for doubt in (DOUBT, 0.0))

    def ratio(run):
        covariances = {k: wide if k == run else none for k in range(RUNS)}
        return density_left_out(DENSITY, system, LeftOut(only_one, system.recording, covariances),
                                weights(system)) / DENSITY
    right, wrong = ratio(2), ratio(1)
    assert (right < 1.05).all() and (wrong > 1.3).sum() >= 2


def test_friction_in_doubt_is_no_drift(system):
    """Coulomb's level and viscous friction off by what is stated: little of it is left."""
    residual = noise(system) + off(system)
    stated, alone = (drift_of(system, left_out(system, residual, doubt), weights(system))[:, 1:]
                     for doubt in (DOUBT, 0.0))
    assert (alone > 0.1 * DOUBT).all() and (stated < 0.75 * alone).all()
