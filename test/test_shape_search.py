"""Shapes that friction turns by are found where it turns."""

from core_helpers import four_axes
import numpy as np
import pytest
from test_identification import Made, TRUE_SHAPE

from hand_load_estimator.effects.own_travel import BOTH
from hand_load_estimator.identification.shape_search import (_price, EXCUSED, search_shapes,
                                                             TRAVEL)
from hand_load_estimator.torque.columns import EffectUse


def test_contacts_that_are_a_spring_for_most_of_the_way_are_found_with_their_travel(monkeypatch):
    monkeypatch.setitem(TRUE_SHAPE, 'presliding_distance', 8e-4)
    made = Made(four_axes(), recordings=2, plastic=0.5)
    uses = tuple(EffectUse(u.name, u.joint) for u in made.uses)
    for again in (False, True):
        uses = search_shapes(made.robot, uses, made.evidence, made.x, made.density,
                             0.04 * made.robot.limits.torque, again)
    turning = [u.shape for u in uses if u.name == 'presliding_hysteresis']
    assert [shape['plastic'] for shape in turning] == [0.5] * 4
    np.testing.assert_allclose([s['presliding_distance'] for s in turning], 8e-4, rtol=0.15)


def test_travels_alike_cost_alike_and_none_gains_by_being_short():
    use = EffectUse('presliding_hysteresis', 0)
    travel = next(s for s in use.effect.shapes if s.name == TRAVEL)
    plain, sprung = ({**use.shape, TRAVEL: 2e-3, 'plastic': plastic} for plastic in (BOTH, 0.5))
    assert _price(travel, plain) == _price(travel, sprung) and plain != sprung
    assert _price(travel, plain) == pytest.approx(EXCUSED * np.log(10.0))
    assert _price(travel, {**plain, TRAVEL: 1e-5}) == 0.0


@pytest.mark.parametrize('seed', [1, 2])
def test_where_nothing_tells_how_far_friction_turns_it_turns_at_once(monkeypatch, seed):
    """A travel by chance excuses what turns from the fit, and friction is then off there."""
    monkeypatch.setitem(TRUE_SHAPE, 'presliding_distance', 5e-5)
    robot = four_axes()
    noisy = (0.2 * robot.limits.torque.max()) ** 2 * 0.02
    made = Made(robot, seed=seed, density=noisy, recordings=2, seconds=15.0)
    uses = tuple(EffectUse(u.name, u.joint) for u in made.uses)
    for again in (False, True):
        uses = search_shapes(robot, uses, made.evidence, made.x, np.full(robot.n, noisy),
                             0.04 * robot.limits.torque, again)
    travels = [u.shape['presliding_distance'] for u in uses if u.name == 'presliding_hysteresis']
    assert max(travels) < 3e-4
