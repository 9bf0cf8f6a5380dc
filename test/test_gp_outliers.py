"""Outliers before the histogram filter: refused, they widen the residual, but not for good."""

from dataclasses import replace

from core_helpers import feed
from difference_helpers import evidence, model, stream
from gp_helpers import LOAD, pipeline
import numpy as np
import pytest

from hand_load_estimator.estimators.gp_histogram import GpHistogram, LOCKED, ResidualScale
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.learning.learn_difference import learn_difference
from hand_load_estimator.load import products_from_shape


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return an artefact for the arm with unknown friction."""
    out = tmp_path_factory.mktemp('gp')
    learn_difference(out, model(), evidence())
    return out


@pytest.fixture
def gate(folder, monkeypatch):
    """Return ask(sigmas): does a sample so far off on every joint count, after 4 s of motion."""
    made, taken = pipeline('gp_histogram', folder), []
    take = GpHistogram._take
    monkeypatch.setattr(GpHistogram, '_take', lambda self, *given: (
        taken.append(given), take(self, *given)))
    feed(made, stream(LOAD, 4.6, seed=8))
    method, (sample, prediction, columns) = made.method, taken[-1]
    assert method.refused < 0.1 * len(taken)

    def ask(sigmas):
        off = sigmas * model().residuals.rmse
        believed = prediction.load_columns @ products_from_shape(np.concatenate(
            [method._places.best, load_prior(model().robot).mean[4:]]))
        told = columns[:, 10:] @ method._plain.nuisances
        method._plain.innovation = off
        return method._opens(sample, replace(prediction, difference=believed + told + off),
                             columns, sample.dt / prediction.density)
    return ask


def test_e2_4_an_outlier_raises_the_entropy_and_does_not_count(gate):
    assert gate(0.0) and gate(1.0)
    assert not gate(8.0)
    assert gate(0.0)


def test_e2_4_an_outlier_in_a_stream_is_refused_and_widens_the_residual(folder):
    """60 ms of torque eight standard deviations off, where no joint turns around, through all."""
    made, seen = pipeline('gp_histogram', folder), []
    off = 8.0 * model().residuals.rmse / model().robot.effort.torque_constants
    for m in stream(LOAD, 4.0, seed=9):
        struck = 103.8 <= m.stamp < 103.86
        estimate = made.joint_state(m.stamp, m.names, m.position, m.velocity,
                                    m.effort + off * struck)
        if estimate is not None:
            seen.append((m.stamp, made.method.refused, made.method._scale.value,
                         (estimate.mean[0] - LOAD.mass) / estimate.std[0]))
    stamps, refused, scale, away = np.array(seen).T
    before, after = stamps < 103.8, stamps > 103.87
    assert refused[after][0] > refused[before][-1]
    assert scale[after][0] > scale[before][-1] + 0.01
    assert np.abs(away[after]).max() < 4.0


def test_e2_4_the_gate_does_not_lock(gate):
    """What contradicts for good comes to count, and widens what is believed."""
    asked = [gate(8.0) for _ in range(round(2.0 * LOCKED / 0.02))]
    assert not asked[0] and all(asked[-10:])


def test_the_residuals_scale_follows_what_does_not_fit():
    scale = ResidualScale()
    for _ in range(3000):
        scale = scale.after(50.0, 0.02)
    assert scale.value > 20.0
    assert ResidualScale().after(0.1, 0.02).value == 1.0
