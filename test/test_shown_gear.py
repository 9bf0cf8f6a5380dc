"""Friction of gears whose torque turns round within the motion filter's memory."""

from types import SimpleNamespace

from core_helpers import four_axes
from effect_helpers import model_with
import numpy as np
import pytest

from hand_load_estimator.effects.shown_gear import shown_side, shown_size
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.motion import MotionFilter
from hand_load_estimator.torque.model_follower import ModelFollower
from hand_load_estimator.torque.shown_links import shown_links, SPREAD

RATE, SHARE = 500.0, 0.6
LOAD = LoadParameters(3.0, [0.0, 0.0, 0.3], 0.02 * np.eye(3))


def test_size_is_that_of_all_torques_within_the_filter():
    """Against a hundred thousand draws; without a spread it is the plain size and sign."""
    draws = np.random.default_rng(1).normal(size=100_000)
    for torque, way in ((0.0, 2.0), (1.0, -2.0), (-3.0, 2.0), (9.0, 1.0)):
        size = np.abs(torque + way * draws)
        assert shown_size(torque, way) == pytest.approx(size.mean(), abs=0.01)
        assert shown_side(torque, way) == pytest.approx(
            np.sign(torque + way * draws).mean(), abs=0.01)
    still = np.array([-2.0, 0.0, 3.0])
    np.testing.assert_allclose(shown_size(still, 0.0), np.abs(still), atol=1e-8)
    np.testing.assert_array_equal(shown_side(still, np.zeros(3)), np.sign(still))


def snapped(robot, mean, loaded):
    """
    Return MotionSamples of an arm whose joint 2 slides and is braked hard, and what slides.

    Its torque is that of the links, of LOAD, and of SHARE of the gear's as friction.
    """
    motion_filter, out = MotionFilter(robot.n), []
    q, v = np.array([0.3, 0.4, -2.9, 0.2]), np.zeros(robot.n)
    v[2], dt = 1.0, 1.0 / RATE
    for k in range(int(1.2 * RATE)):
        t = k * dt
        a = np.zeros(robot.n)
        # Quicker and quicker, then suddenly slower: the joint goes the same way all the time.
        a[2] = 3.0 if t < 0.6 else -45.0 * np.sin(np.pi * min(t - 0.6, 0.1) / 0.1) ** 2
        links = robot.link_regressor(q, v, a)
        gear = links @ mean[:10 * robot.n]
        if loaded:
            gear = gear + robot.load_columns(links) @ LOAD.to_products()
        effort = gear + SHARE * np.abs(gear) * np.sign(v)
        sample = motion_filter.update(t, q.copy(), v.copy(), effort)
        if sample is not None and not sample.fresh:
            out.append(sample)
        q, v = q + dt * v + 0.5 * dt * dt * a, v + dt * a
    return out


@pytest.mark.parametrize('loaded', [False, True])
def test_a_snap_leaves_half_as_much_of_the_friction_of_teeth(loaded, monkeypatch):
    """What a gear's own torque makes of friction is followed through a sudden stop."""
    robot = four_axes()
    model = model_with(robot, ('load_dependent_friction',), {'load_dependent_friction': (SHARE,)})
    mean = model.mean.copy()
    mean[10 * robot.n:][[use.name != 'load_dependent_friction' for use in model.uses
                         for _ in use.effect.parameters]] = 0.0
    object.__setattr__(model, 'mean', mean)
    samples = snapped(robot, mean, loaded)
    left = [rms_left(model, samples, loaded)]
    # As it was: the size of what the filter shows.
    for user in ('load_through_effects', 'columns'):
        monkeypatch.setattr(f'hand_load_estimator.torque.{user}.shown_links_and_way', _no_way)
    left.append(rms_left(model, samples, loaded))
    assert left[0] < 0.55 * left[1], left


def _no_way(robot, motion):
    links = shown_links(robot, motion)
    return links, np.zeros_like(links)


def rms_left(model, samples, loaded):
    """Return the RMS [Nm] of what model and load leave of the torque of joint 2."""
    follower = ModelFollower(model)
    load = LOAD if loaded else LoadParameters()
    follower.carry(SimpleNamespace(mean=load.to_message()),
                   SimpleNamespace(tared=np.zeros(10)))
    left = []
    for sample in samples:
        seen = follower.update(sample)
        if sample.stamp > 20.0 * SPREAD:
            left.append(seen.difference - seen.load_columns @ load.to_products())
    return np.sqrt(np.mean(np.square(left)[:, 2]))
