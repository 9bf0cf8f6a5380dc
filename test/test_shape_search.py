"""Shapes that friction turns by are found where it turns."""

from core_helpers import four_axes
import numpy as np
from test_identification import Made, TRUE_SHAPE

from hand_load_estimator.identification.shape_search import search_shapes
from hand_load_estimator.torque.columns import EffectUse


def test_a_power_of_turning_is_found_with_its_travel(monkeypatch):
    monkeypatch.setitem(TRUE_SHAPE, 'presliding_distance', 8e-4)
    made = Made(four_axes(), recordings=2, power=1.5)
    uses = tuple(EffectUse(u.name, u.joint) for u in made.uses)
    for again in (False, True):
        uses = search_shapes(made.robot, uses, made.evidence, made.x, made.density,
                             0.04 * made.robot.limits.torque, again)
    turning = [u.shape for u in uses if u.name == 'presliding_hysteresis']
    assert [shape['power'] for shape in turning] == [1.5] * 4
    np.testing.assert_allclose([s['presliding_distance'] for s in turning], 8e-4, rtol=0.15)
