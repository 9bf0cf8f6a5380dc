"""Friction as the motion filter shows it: as if the friction itself had been filtered."""

from dataclasses import replace

from core_helpers import four_axes, presliding_path
from effect_helpers import model_with
import numpy as np
import pytest
from test_effects_online import along, filtered

from hand_load_estimator.effects.own_travel import BOTH
from hand_load_estimator.effects.stribeck_curve import left
from hand_load_estimator.motion import Motion, MotionFilter
from hand_load_estimator.torque.columns import torque_columns
from hand_load_estimator.torque.model_file import read_model, write_model
from hand_load_estimator.torque.model_follower import ModelFollower
from hand_load_estimator.torque.motion_inputs import motion_input
from hand_load_estimator.torque.presliding import Turning
from hand_load_estimator.torque.shown_along import shown_along, shown_as_one
from hand_load_estimator.torque.shown_friction import course_behind
from hand_load_estimator.torque.shown_stream import ShownStream

TRAVEL, PLASTIC, VELOCITY = 1e-3, 0.8, 0.08
OWN = {'travel': 3e-3, 'plastic': 0.8, 'stribeck_velocity': 0.08, 'exponent': 1.4,
       'velocity_range': 30.0}
# Travels and plastics by which the joints' friction turns where none of its own is given.
WAY = np.full(4, 1e-3), np.full(4, BOTH)


def contacts(q, v):
    """Return what contacts that bend up to the falling level bear (N,), step by small step."""
    out = np.zeros(len(q))
    for k in range(1, len(q)):
        level = np.exp(-abs(v[k]) / VELOCITY)
        way = q[k] - q[k - 1]
        out[k] = level * Turning(PLASTIC).turned(out[k - 1] / level, way, level * TRAVEL)
    return out


@pytest.fixture(scope='module')
def swing():
    """Return the Motion of a swing of four joints whose efforts are their friction."""
    stamps = np.arange(0.0, 4.0, 0.0002)
    q, v = 0.02 * np.sin(15.0 * stamps)[:, None], 0.3 * np.cos(15.0 * stamps)[:, None]
    friction = contacts(q[:, 0], v[:, 0])[:, None]
    motion, told = MotionFilter(4), (stamps, *(np.tile(each, 4) for each in (q, v, friction)))
    rows = [motion.update(*row) for row in zip(*(column[::10] for column in told))]
    return Motion.of([replace(row, fresh=False) for row in rows if row is not None])


def seen(motion):
    """Return what shown_along takes of a Motion."""
    return motion.course, motion.dt, np.zeros_like(motion.q)


def test_it_is_what_the_filter_makes_of_friction(swing):
    friction, v = swing.effort[:, 0], swing.v
    shown = shown_along(*seen(swing), WAY)(0, TRAVEL, PLASTIC, VELOCITY)
    z, _ = presliding_path(swing.q, v, swing.dt, np.array([TRAVEL]), np.array([PLASTIC]))
    plain = z[:, 0] * np.exp(-np.abs(v[:, 0]) / VELOCITY)
    late, size = slice(50, None), np.std(friction)
    assert np.std(shown[late] - friction[late]) < 0.02 * size
    assert np.std(plain[late] - friction[late]) > 0.5 * size


def test_columns_and_follower_take_the_motion_as_it_was_measured(swing):
    late, friction = slice(50, None), swing.effort[:, 0]
    robot, peak = four_axes(), (TRAVEL, PLASTIC, VELOCITY)
    x, _ = motion_input(robot, swing, np.full(4, 1e-3))
    shape = dict(zip(('travel', 'plastic', 'stribeck_velocity'), peak))
    left_of_it = []
    for level in (0.0, 1.0):
        follower = ModelFollower(model_with(robot, ('stribeck_friction',),
                                            {'stribeck_friction': (level, 0.0)}, shape))
        left_of_it.append([follower.update(sample).difference[0] for sample in swing.samples()])
    online = np.subtract(*left_of_it)
    for shown in (x.shown(0, *peak), online):
        assert np.std(shown[late] - friction[late]) < 0.02 * np.std(friction[late])


@pytest.mark.parametrize('peak', [(), (VELOCITY,)])
def test_without_a_travel_of_its_own_it_turns_with_all_friction_of_the_joint(swing, peak):
    stamps = np.arange(0.0, 4.0, 0.0002)
    q, v = 0.02 * np.sin(15.0 * stamps)[:, None], 0.3 * np.cos(15.0 * stamps)[:, None]
    friction, _ = presliding_path(q, v, np.full(len(q), 0.0002), WAY[0][:1], np.full(1, PLASTIC))
    if peak:
        friction = friction * left(v, 0.0, *peak)
    motion = MotionFilter(1)
    samples = [motion.update(*row) for row in zip(stamps[::10], q[::10], v[::10], friction[::10])]
    wanted = np.array([s.effort[0] for s in samples if s is not None])
    own = WAY[0], np.full(4, PLASTIC)
    shown = shown_along(*seen(swing), own)(0, np.inf, np.inf, *peak)
    assert np.std(shown[50:] - wanted[50:]) < 0.02 * np.std(wanted)


@pytest.mark.parametrize('speed, begins', [(0.3, 1.0), (-0.3, -1.0), (0.01, 0.0)])
def test_a_joint_that_is_first_seen_in_motion_slides(speed, begins):
    t = 0.02 * np.arange(40)[:, None]
    course = course_behind(speed * t, np.full_like(t, speed), 0.0 * t, np.full(40, 0.02))
    motion = course, np.full(40, 0.02), 0.0 * t
    own = np.full(1, 0.3), np.full(1, np.inf)
    whole = shown_along(*motion, own)(0, np.inf, np.inf, VELOCITY)
    assert whole[0] == pytest.approx(begins * np.exp(-0.3 / VELOCITY), abs=0.02)
    stream = ShownStream(own)
    online = [stream.at(*row, 0)(0, np.inf, np.inf, VELOCITY)[0] for row in zip(*motion)]
    np.testing.assert_allclose(online, whole, atol=1e-12)


def test_a_peak_that_comes_back_has_to_bend_the_contacts_again():
    # Fast, then slow within a tenth of the travel: the level is up, the contacts are not.
    v = np.r_[np.full(100, 0.5), np.full(100, 1e-3)]
    # What the filter shows of such a joint lags by 30 ms.
    q, dt = np.cumsum(v) * 0.02 - 0.03 * v, np.full(200, 0.02)
    still = np.zeros((200, 1))
    course = course_behind(q[:, None], v[:, None], still, dt)
    shown = shown_along(course, dt, still, (np.full(1, 1e-3), np.full(1, np.inf)))(
        0, 1e-3, np.inf, 0.02)
    assert shown[99] < 1e-3
    assert 0.02 < shown[105] < 0.3
    assert shown[-1] > 0.6


def test_a_peak_falls_by_its_exponent_and_later_when_warm():
    assert left(0.05, 0.0, 0.05) == pytest.approx(np.exp(-1.0))
    assert left(-0.1, 0.0, 0.05, 2.0) == pytest.approx(np.exp(-4.0))
    assert left(0.05 * np.e, 30.0, 0.05, 1.3, 30.0) == pytest.approx(np.exp(-1.0))


def test_the_motion_before_a_filter_that_was_not_there(swing):
    """As far as q, v and a tell: what the acceleration changed by within the filter is missing."""
    found = course_behind(swing.q, swing.v, swing.a, swing.dt)
    assert found.shape == swing.course.shape
    late = slice(50, None)
    for values, true, share in zip(found[late].swapaxes(0, 1), swing.course[late].swapaxes(0, 1),
                                   (0.01, 0.1)):
        assert np.abs(values - true).max() < share * np.abs(true).max()


@pytest.mark.parametrize('plastic', [BOTH, PLASTIC, np.array([PLASTIC, BOTH])])
def test_a_stream_is_as_the_whole(swing, plastic):
    motion = seen(swing)
    places = (np.array([0, 0]), np.array([TRAVEL, 3 * TRAVEL]), plastic,
              np.array([VELOCITY, np.inf]))
    stream = ShownStream(WAY)
    online = np.array([stream.at(*row, 0)(*places)[0] for row in zip(*motion)])
    np.testing.assert_allclose(online, shown_along(*motion, WAY)(*places), atol=1e-12)
    assert np.abs(online).max() > 0.5
    first = [column[0] for column in motion]
    one = stream.at(*first, 0)
    np.testing.assert_array_equal(one(*places), one(*places), 'asked twice it goes on once')
    stream.restart()
    np.testing.assert_array_equal(stream.at(*first, 0)(*places),
                                  ShownStream(WAY).at(*first, 0)(*places))


def test_recordings_beside_one_another_are_as_each_alone(swing):
    motion = seen(swing)
    parts = [tuple(column[rows] for column in motion) for rows in (slice(90), slice(40, None))]
    places = np.array([0, 0]), np.array([TRAVEL, 3 * TRAVEL]), PLASTIC, VELOCITY
    each = [shown_along(*part, WAY) for part in parts]
    together = shown_as_one(each)
    np.testing.assert_array_equal(together(*places), np.concatenate([s(*places) for s in each]))
    assert len(together(0, TRAVEL, np.inf)) == sum(len(part[0]) for part in parts)


@pytest.mark.parametrize('name, values', [('stribeck_friction', (3.0, 0.01)),
                                          ('load_dependent_friction', (0.1,))])
def test_online_is_as_offline_and_a_file_keeps_it(name, values, tmp_path):
    model = model_with(four_axes(), (name,), {name: values}, OWN)
    write_model(tmp_path / 'model.yaml', model)
    model = read_model(tmp_path / 'model.yaml')
    for use in (u for u in model.uses if u.name == name):
        assert use.shape == {figure: OWN[figure] for figure in use.shape}
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
