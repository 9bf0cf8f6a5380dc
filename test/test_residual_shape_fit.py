"""Shapes settle where they fit best, from beside it, and those that go together go together."""

import numpy as np
import pytest
from residual_helpers import declared_model, Hidden, noise_of, on, play, recorded

from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.effects.torque_ripple import waves
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis
from hand_load_estimator.residual.tracing.shape_doubt import shape_doubt
from hand_load_estimator.residual.tracing.shape_fit import settled


def late(run: Hidden):
    """Effort of 33 ms ago."""
    time = run.motion.stamp
    return np.stack([np.interp(time - 0.033, time, torque) for torque in run.torque.T],
                    axis=1) - run.torque


def settle(hidden, name, shape, joint):
    """Return shape and gain [nats] of an effect before and after it settled from a shape."""
    model, effect = declared_model(), EFFECTS[name]
    residual = find_residual(model, recorded(hidden))
    scale = effect.std(model.robot.limits.torque[joint])
    start = Hypothesis(name, joint, {
        joint: effect.columns(residual.x, joint, shape) * scale}, scale, shape)
    blocks = residual.blocks()
    score = blocks.evaluate(start.columns)
    (found, better), trials = settled(start, score, blocks, model, residual,
                                      lambda _, of: of.gain)
    assert trials > 0 and all(type(value) is float for value in found.shape.values())
    return found.shape, score.gain, better.gain


@pytest.mark.parametrize('start', [0.025, 0.042])
def test_a_delay_settles_between_the_grids_values(start):
    shape, before, after = settle(on(1, 5.0, late), 'time_delay', {'shift': start}, 1)
    # Half a nat of eight thousand less is within 6 % of it.
    assert shape['shift'] == pytest.approx(0.033, rel=0.06)
    assert after > before + 10.0


def two_waves(run: Hidden):
    """A ripple of 37 periods per turn on joint 2, with its second harmonic."""
    first, second = (waves(run.x.q, run.x.v, k * 37.0) for k in (1.0, 2.0))
    return first[0] + 0.4 * second[1]


@pytest.mark.parametrize('start', [36.85, 37.1])
def test_a_ripple_settles_within_a_hundredth_of_a_radian_at_the_ends_of_the_motion(start):
    shape, before, after = settle(on(2, 3.0, two_waves), 'torque_ripple', {'periods': start}, 2)
    # The joint swings by a radian or two: 0.1 periods per turn are 0.1 rad and more there.
    assert shape['periods'] == pytest.approx(37.0, abs=0.01)
    assert after > before + 10.0


def test_shapes_that_make_up_for_one_another_settle_together():
    """A longer gap with less lag is across at the same moment."""
    start = {'travel': 0.0046, 'lag': 0.009, 'pose_share': 1.0, 'impact': 0.007}
    shape, before, after = settle(on(1, 3.0, play), 'backlash', start, 1)
    _, truth, _ = settle(on(1, 3.0, play), 'backlash', {
        'travel': 0.004, 'lag': 0.012, 'pose_share': 1.0, 'impact': 0.009}, 1)
    assert shape['travel'] == pytest.approx(0.004, rel=0.08)
    assert shape['impact'] == pytest.approx(0.009, rel=0.1)
    assert after - before > 0.8 * (truth - before) > 100.0


def test_where_nothing_is_to_be_gained_the_shape_stays_or_gains():
    shape, before, after = settle(on(1, 5.0, late), 'time_delay', {'shift': 0.033}, 1)
    assert after >= before and noise_of(declared_model().robot).all()
    assert shape['shift'] == pytest.approx(0.033, rel=0.03)


def test_an_effect_without_the_shapes_it_may_have_stays_as_it_is():
    # Friction with the load, turning as all friction does: on real arms this ended in a traceback.
    model, plain = declared_model(), {'travel': np.inf, 'plastic': 2.0}
    residual = find_residual(model, recorded(on(1, 5.0, late)))
    start = Hypothesis('load_dependent_friction', 1, {1: residual.x.sign[:, 1:2]},
                       np.ones(1), plain)
    blocks = residual.blocks()
    score = blocks.evaluate(start.columns)
    assert settled(start, score, blocks, model, residual, lambda _, of: of.gain) == (
        (start, score), 0)
    doubt = shape_doubt(start, blocks, model, residual)
    assert doubt.std == {} and not doubt.of_parameters.any()
