"""The interval of a gap's travel holds what lag, pose and inertia leave open of it."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import declared_model, diagnosed, on, play, recorded

from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.torque.columns import play_columns
from hand_load_estimator.torque.play import PlayAlong

TRUE = {'travel': 0.004, 'lag': 0.012, 'pose_share': 1.0, 'impact': 0.009}
HEAVIER = 1.8


def heavy_play(run):
    """As play, but what crosses is HEAVIER than the links usually are, whatever the pose."""
    gear = np.array([run.robot.rigid_torque(*row) for row in zip(run.x.q, run.x.v, run.x.a)])
    along = play_columns(run.robot, run.x.q, gear, run.motion.dt)
    heavier = replace(along, usual=HEAVIER * np.asarray(along.usual))
    return heavier(np.arange(4), *(np.full(4, TRUE[name] if name != 'pose_share' else 0.0)
                                   for name in ('travel', 'lag', 'pose_share', 'impact')))


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
        assert std < (1.0 if name == 'pose_share' else 0.7 * true), name


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
