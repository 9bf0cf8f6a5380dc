"""The interval of a gap's travel holds what lag, pose and inertia leave open of it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import declared_model, diagnosed, on, play, recorded

from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.tracing import gap_doubt
from hand_load_estimator.torque.columns import play_columns
from hand_load_estimator.torque.play import PlayAlong

TRUE = {'travel': 0.004, 'lag': 0.012, 'pose_share': 1.0, 'impact': 0.009}
HEAVIER = 2.5


def heavy_play(run):
    """As play, but what crosses is HEAVIER than the links usually are, whatever the pose."""
    gear = np.array([run.robot.rigid_torque(*row) for row in zip(run.x.q, run.x.v, run.x.a)])
    along = play_columns(run.robot, run.x.q, gear, run.motion.dt)
    heavier = replace(along, usual=HEAVIER * np.asarray(along.usual))
    return heavier(np.arange(4), *(np.full(4, TRUE[name] if name != 'pose_share' else 0.0)
                                   for name in ('travel', 'lag', 'pose_share', 'impact')))


@pytest.mark.parametrize('narrow, true_share', [(0.01, 0.5), (0.03, 0.95)])
def test_draws_are_as_wide_as_what_is_told(monkeypatch, narrow, true_share):
    """Of a gain that is a normal distribution's: travel and lag together are not known."""
    names, true = list(TRUE), np.array([np.log(0.01), np.log(0.015), true_share, np.log(0.008)])
    root = np.linalg.inv(np.diag([narrow, narrow, 0.02, 0.05])) @ np.array([
        [1.0, 0.7, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    found = dict(zip(names, np.where(np.array(names) == 'pose_share', true, np.exp(true))))

    def evaluate(shape):
        figures = np.array([shape[n] if n == 'pose_share' else np.log(shape[n]) for n in names])
        gain = 4000.0 - 0.5 * np.sum((root @ (figures - true)) ** 2)
        return SimpleNamespace(by_block=np.array([gain]), theta=np.array([shape['travel']]))

    monkeypatch.setattr(gap_doubt, 'of_shapes', lambda _, shapes, *__: [
        SimpleNamespace(columns=shape) for shape in shapes])
    plain = np.array([name == 'pose_share' for name in names])
    draws, _, weights = gap_doubt._cooled(SimpleNamespace(shape=found, columns=found), plain,
                                          SimpleNamespace(evaluate=evaluate), None, None)
    mean, covariance = gap_doubt._moments(draws, weights)
    # Weighed as if 4000 x ROUGH nats were one, beside what is expected before any gain.
    prior = np.diag(np.where(plain, 1.0, 1.0 / gap_doubt.FIRST ** 2))
    expected = np.linalg.inv(root.T @ root / (4000.0 * gap_doubt.ROUGH) + prior)
    std = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(np.sqrt(np.diag(covariance))[[0, 1, 3]], std[[0, 1, 3]], rtol=0.4)
    assert (np.abs(mean - true) < std)[[0, 1, 3]].all()
    assert np.sqrt(covariance[2, 2]) < 1.4 * std[2]


def gap_in(diagnosis):
    (found,) = [f for f in diagnosis.findings if f.name == 'backlash']
    return found.parameters


@pytest.mark.parametrize('size, seed', [(2.0, 5), (6.0, 6)])
def test_figures_lie_within_their_intervals(size, seed):
    """Of the first the pose is found to show, of the other not: the travel goes with that."""
    figures = gap_in(diagnose(declared_model(), recorded(on(1, size, play), seed=seed))[0])
    for name, true in TRUE.items():
        value, std, _ = figures[name]
        assert abs(value - true) < 2.0 * std, name
        assert name == 'pose_share' or std < 0.8 * true, name


def test_what_crosses_may_be_another_inertia():
    figures = gap_in(diagnosed(on(1, 3.0, heavy_play))[0])
    travel, std, _ = figures['travel']
    assert abs(travel - TRUE['travel']) < 2.0 * std < 2.0 * travel


def test_only_the_product_of_travel_and_inertia_shows():
    factors, gap = np.ones((300, 1)), 0.02
    torque = np.cumsum(np.random.default_rng(0).normal(size=(300, 1)), axis=0)
    light, heavy = (PlayAlong(((torque, 2.0 * factors, np.full(300, 0.02)),), [usual])
                    for usual in (2.0, 2.0 * HEAVIER))
    np.testing.assert_allclose(light(0, HEAVIER * gap, 0.02, 0.0, 0.01),
                               heavy(0, gap, 0.02, 0.0, 0.01), atol=1e-12)
    np.testing.assert_allclose(light.off_usual(0), 0.0)
    np.testing.assert_allclose(heavy.off_usual(0), -np.log(HEAVIER))
