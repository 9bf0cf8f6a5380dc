"""The interval of a gap's travel holds what its inertia leaves open."""

from types import SimpleNamespace

import numpy as np
import pytest

from hand_load_estimator.residual.tracing.gap_doubt import with_unknown_inertia
from hand_load_estimator.residual.tracing.shape_doubt import NO_DOUBT, ShapeDoubt
from hand_load_estimator.torque.play import PlayAlong

TRAVEL, STD = 0.01, 1e-4


def gap_of(pose_share, name='backlash'):
    return SimpleNamespace(name=name, joint=1, shape={'travel': TRAVEL, 'pose_share': pose_share})


def along(factors, usual=2.0):
    """Return what holds a PlayAlong of two joints; factors (N,): the second's inertia / usual."""
    inertia = usual * np.stack([np.ones_like(factors), factors], axis=1)
    rng = np.random.default_rng(0)
    torque = np.cumsum(rng.normal(size=inertia.shape), axis=0)
    return SimpleNamespace(x=SimpleNamespace(play=PlayAlong(
        ((torque, inertia, np.full(len(factors), 0.02)),), [usual, usual])))


def test_only_the_product_of_travel_and_inertia_shows():
    factors = np.ones(300)
    gap, heavier = 0.02, along(factors, 2.0 * 1.8).x.play
    np.testing.assert_allclose(along(factors).x.play(1, 1.8 * gap, 0.02, 0.0, 0.01),
                               heavier(1, gap, 0.02, 0.0, 0.01), atol=1e-12)


def test_where_the_pose_does_not_show_any_inertia_may_have_crossed():
    factors = np.exp(0.6 * np.tile([-1.0, 1.0], 100))
    doubt = ShapeDoubt({'travel': STD, 'lag': 1e-3}, np.eye(1))
    found = {share: with_unknown_inertia(doubt, gap_of(share), along(factors))
             for share in (0.0, 0.5, 1.0)}
    assert found[0.0].std['travel'] == pytest.approx(np.hypot(STD, 0.6 * TRAVEL))
    assert found[0.5].std['travel'] == pytest.approx(np.hypot(STD, 0.3 * TRAVEL))
    assert found[1.0].std['travel'] == STD
    assert all(doubt.std['lag'] == 1e-3 for doubt in found.values())


def test_other_effects_keep_their_doubt():
    doubt = ShapeDoubt({'travel': STD}, np.eye(1))
    assert with_unknown_inertia(doubt, gap_of(0.0, 'stribeck_friction'), None) is doubt
    assert with_unknown_inertia(NO_DOUBT, gap_of(0.0), None) is NO_DOUBT
