"""How friction turns settles beside everything else of a joint."""

from dataclasses import replace

from core_helpers import four_axes
import numpy as np
import pytest
from test_identification import Made, TRUE_SHAPE

from hand_load_estimator.effects import PRESLIDING
from hand_load_estimator.effects.own_travel import BOTH
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.identification.regression_system import System
from hand_load_estimator.identification.turning_fit import with_turning_fitted
from hand_load_estimator.residual.add import identified_again
from hand_load_estimator.torque.columns import EffectUse
from hand_load_estimator.torque.presliding import Turning

TRAVEL = 'presliding_distance'


def turning_of(uses):
    """Return {joint: (travel [rad], plastic)}."""
    return {u.joint: (u.shape[TRAVEL], u.shape['plastic']) for u in uses if u.name == PRESLIDING}


def reversal(travel, plastic):
    """Return z after ways from one level."""
    return Turning(plastic).turned(-1.0, np.linspace(0.0, 0.1, 50), travel)


def settled(made, uses, joints):
    """Return uses with the turning of joints settled on what was made."""
    system = System(made.robot, uses, made.evidence, made.x)
    return with_turning_fitted(system, uses, made.evidence, made.x, made.density, joints)


@pytest.mark.parametrize('plastic, first', [(0.5, 1.0), (BOTH, 1.5)])
def test_it_settles_from_beside_where_it_is(monkeypatch, plastic, first):
    monkeypatch.setitem(TRUE_SHAPE, TRAVEL, 0.02)
    made = Made(four_axes(), recordings=2, plastic=plastic)
    beside = {TRAVEL: 0.022, 'plastic': first}
    uses = tuple(replace(u, shape={**u.shape, **beside}) if u.name == PRESLIDING else
                 EffectUse(u.name, u.joint, u.shape) for u in made.uses)
    found = turning_of(settled(made, uses, [1, 3]))
    for j in (0, 2):
        assert found[j] == (0.022, first), 'of a joint that was not asked for nothing changes'
    for j in (1, 3):
        assert found[j][0] == pytest.approx(0.02, rel=0.03)
        np.testing.assert_allclose(reversal(*found[j]), reversal(0.02, plastic), atol=0.04)


def test_a_joint_without_presliding_has_none_to_settle():
    made = Made(four_axes(), recordings=1)
    uses = tuple(u for u in made.uses if u.name != PRESLIDING)
    assert settled(made, uses, [0]) is uses


def test_where_it_is_right_nothing_moves():
    for seed in range(3):
        made = Made(four_axes(), recordings=1, seed=seed)
        assert turning_of(settled(made, made.uses, range(4))) == turning_of(made.uses)


def test_a_better_model_has_it_and_no_old_deviation(monkeypatch):
    monkeypatch.setitem(TRUE_SHAPE, TRAVEL, 0.02)
    made = Made(four_axes(), recordings=2, plastic=0.6)
    model = identify(made.robot, made.evidence[:1])
    wrong = tuple(replace(u, shape={**u.shape, TRAVEL: 0.022, 'plastic': 1.0},
                          shape_std={TRAVEL: 1e-5}) if u.name == PRESLIDING else u
                  for u in model.uses)
    found = identified_again(model, wrong, made.evidence, {(PRESLIDING, 1)})
    turning = turning_of(found.uses)
    assert turning[1][0] == pytest.approx(0.02, rel=0.03)
    assert turning[1][1] == pytest.approx(0.6, rel=0.1)
    assert turning[2] == (0.022, 1.0), 'it was not found there'
    assert next(u for u in found.uses if (u.name, u.joint) == (PRESLIDING, 1)).shape_std == {}
