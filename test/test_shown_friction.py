"""Friction as the motion filter shows it: as if the friction itself had been filtered."""

from dataclasses import replace

from core_helpers import four_axes
from effect_helpers import model_with
import numpy as np
import pytest
from test_effects_online import along, filtered

from hand_load_estimator.model_file import read_model, write_model
from hand_load_estimator.model_follower import ModelFollower
from hand_load_estimator.motion import MotionFilter
from hand_load_estimator.presliding import presliding_path
from hand_load_estimator.shown_friction import shown_along, ShownStream, unfiltered
from hand_load_estimator.torque_columns import motion_input, torque_columns

TRAVEL, POWER, VELOCITY = 1e-3, 2.0, 0.08
OWN = {'travel': 3e-3, 'power': 2.0, 'stribeck_velocity': 0.08}


@pytest.fixture(scope='module')
def swing():
    """Return (q, v, a, dt) behind the filter of a joint that swings, and its filtered friction."""
    stamps = np.arange(0.0, 4.0, 0.002)
    q, v = 0.02 * np.sin(15.0 * stamps)[:, None], 0.3 * np.cos(15.0 * stamps)[:, None]
    z, _ = presliding_path(q, v, np.full(len(q), 0.002), np.array([TRAVEL]), np.array([POWER]))
    motion = MotionFilter(1)
    rows = [motion.update(*row) for row in zip(stamps, q, v, z * np.exp(-np.abs(v) / VELOCITY))]
    rows = [row for row in rows if row is not None]
    q, v, a, friction = (np.array([getattr(row, name) for row in rows])
                         for name in ('q', 'v', 'a', 'effort'))
    dt = np.array([row.dt for row in rows])
    np.testing.assert_allclose(np.cumsum(dt), [row.stamp for row in rows])
    return q, v, a, dt, friction[:, 0]


def test_it_is_what_the_filter_makes_of_friction(swing):
    q, v, a, dt, friction = swing
    shown = shown_along(q, v, a, dt)(0, TRAVEL, POWER, VELOCITY)
    z, _ = presliding_path(q, v, dt, np.array([TRAVEL]), np.array([POWER]))
    plain = z[:, 0] * np.exp(-np.abs(v[:, 0]) / VELOCITY)
    late, size = slice(50, None), np.std(friction)
    assert np.std(shown[late] - friction[late]) < 0.2 * size
    assert np.std(plain[late] - friction[late]) > 0.5 * size


def test_the_motion_before_the_filter(swing):
    q, v, a, dt, _ = swing
    found, speed = unfiltered(q, v, a)
    times = np.cumsum(dt)
    late = slice(50, None)
    for values, true, share in ((found, 0.02 * np.sin(15.0 * times), 0.01),
                                (speed, 0.3 * np.cos(15.0 * times), 0.1)):
        assert np.abs(values[late, 0] - true[late]).max() < share * np.abs(true).max()


def test_a_stream_is_as_the_whole(swing):
    q, v, a, dt, _ = swing
    places = np.array([0, 0]), np.array([TRAVEL, 3 * TRAVEL]), POWER, np.array([VELOCITY, np.inf])
    stream = ShownStream()
    seen = np.array([stream.at(*row)(*places)[0] for row in zip(q, v, a, dt)])
    np.testing.assert_allclose(seen, shown_along(q, v, a, dt)(*places), atol=1e-12)
    assert np.abs(seen).max() > 0.5
    one = stream.at(q[0], v[0], a[0], 0.02)
    np.testing.assert_array_equal(one(*places), one(*places), 'asked twice it goes on once')
    stream.restart()
    assert np.abs(stream.at(q[0], v[0], a[0], 0.02)(*places)).max() == 0.0


@pytest.mark.parametrize('name, values', [('stribeck_friction', (3.0, 0.01)),
                                          ('load_dependent_friction', (0.1,))])
def test_online_is_as_offline_and_a_file_keeps_it(name, values, tmp_path):
    model = model_with(four_axes(), (name,), {name: values}, OWN)
    write_model(tmp_path / 'model.yaml', model)
    model = read_model(tmp_path / 'model.yaml')
    assert all(use.shape['travel'] == 3e-3 for use in model.uses if use.name == name)
    samples = filtered(3.0, 125.0)
    motion, x, held = along(model, samples)
    whole = torque_columns(model.robot, model.layout, x, model.mean, motion.dt) @ model.mean
    follower = ModelFollower(model)
    online = np.array([follower.update(replace(s, effort=np.zeros(4))).difference
                       for s in samples])
    np.testing.assert_allclose(online, -whole, atol=1e-8)
    plain = replace(model, uses=tuple(
        replace(use, shape={**use.shape, 'travel': np.inf}) if use.name == name else use
        for use in model.uses))
    x, _ = motion_input(model.robot, motion, model.presliding_distance())
    other = torque_columns(model.robot, plain.layout, x, model.mean, motion.dt) @ model.mean
    assert np.abs(other - whole).max() > 0.05
    assert ModelFollower(plain)._shown is None
