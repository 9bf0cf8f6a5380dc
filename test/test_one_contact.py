"""Coulomb friction and Stribeck peak are borne by one contact, whose level falls with speed."""

from dataclasses import replace

from core_helpers import four_axes, TRAVEL
from effect_helpers import model_with
from hand_load_estimator.plant.difficulty import DEFAULT
from hand_load_estimator.plant.friction import draw_friction, friction_along
import numpy as np
from plant_helpers import ur10e
import pytest
from residual_helpers import recorded
from test_contact_level import warming
from test_identification import Made, TRUE_SHAPE

from hand_load_estimator.effects import PRESLIDING
from hand_load_estimator.effects.own_travel import BOTH
from hand_load_estimator.identification.regression_system import System
from hand_load_estimator.identification.turning_fit import PEAK, with_turning_fitted
from hand_load_estimator.motion import Motion, MotionFilter
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.torque.columns import EffectUse
from hand_load_estimator.torque.contact_level import ContactLevel, MOST_PEAK
from hand_load_estimator.torque.model_follower import ModelFollower
from hand_load_estimator.torque.motion_inputs import motion_input
from hand_load_estimator.torque.shown_friction import course_of
from hand_load_estimator.torque.shown_stream import ShownStream


def peaked(times, **shape):
    """Return a TorqueModel whose peak is so many times its Coulomb friction."""
    model = model_with(four_axes(), (PEAK,), {PEAK: (0.0, 0.0)})
    mean, level = model.mean.copy(), 0.02 * model.robot.limits.torque
    for use, where in model.slices():
        if use.name in ('coulomb_friction', PEAK):
            mean[where.start] = level[use.joint] * (times if use.name == PEAK else 1.0)
    uses = tuple(replace(u, shape={**u.shape, **shape}) if u.name == PEAK else u
                 for u in model.uses)
    return replace(model, mean=mean, uses=uses)


def swung(figures, velocity=0.3):
    """Return the Motion of a swing whose efforts are friction of FrictionFigures."""
    n, t = len(figures.coulomb), np.arange(0.0, 4.0, 0.0002)
    q, v = (np.tile(x[:, None], n) for x in (velocity / 15.0 * np.sin(15.0 * t),
                                             velocity * np.cos(15.0 * t)))
    friction = friction_along(figures, v, np.zeros_like(v), np.full(n, 25.0), 0.0002)
    made = MotionFilter(n)
    rows = [made.update(*row) for row in zip(*(x[::10] for x in (t, q, v, friction)))]
    return Motion.of([replace(row, fresh=False) for row in rows if row is not None])


@pytest.mark.parametrize('times, velocity', [(3.0, 0.3), (1.0, 0.1)])
def test_the_simulated_contacts_bear_both_so(times, velocity):
    """Against each turning by itself: as a state of size one times what is left of the peak."""
    robot = ur10e()
    figures, n = draw_friction(robot, DEFAULT, np.random.default_rng(3)), robot.n
    nothing = np.zeros(n)
    figures = replace(figures, static=times * figures.coulomb, asymmetry=nothing,
                      viscous_rest=nothing, viscous_part=nothing, presliding=np.full(n, 2e-3),
                      stribeck_velocity=np.full(n, 0.06), stribeck_exponent=np.ones(n))
    motion = swung(figures, velocity)
    peak = np.array([0.06, 1.0, np.inf])
    level = ContactLevel(nothing, np.full(n, np.inf), np.full(n, times / (1.0 + times)),
                         np.tile(peak[:, None], n))
    # What a reversal of those contacts takes off the work of friction, in half of their levels.
    travel = 0.37 * figures.presliding

    def error(level):
        x, _ = motion_input(robot, motion, travel, np.full(n, 0.5), level)
        shown = x.shown(np.arange(n), np.inf, BOTH, *peak[:, None])
        made = figures.coulomb * (x.z + times * shown)
        return np.std((motion.effort - made)[100:], axis=0)
    assert (error(level) < 0.4 * error(None)).all()
    assert (error(level) < 0.02 * figures.coulomb * (1.0 + times)).all()


def test_it_is_followed_online_as_along_a_recording():
    model = peaked(2.0, exponent=1.3, velocity_range=60.0)
    motion = warming(25.0)
    motion = warming(np.linspace(15.0, 45.0, len(motion.dt)))
    x, doubt = motion_input(model.robot, motion, model.presliding_distance(),
                            model.presliding_plastic(), model.contact_level())
    plain, _ = motion_input(model.robot, motion, model.presliding_distance())
    assert np.abs(x.z - plain.z).max() > 0.05
    follower = ModelFollower(model)
    online = [follower.update(sample) for sample in motion.samples()]
    np.testing.assert_allclose([seen.z for seen in online], x.z, atol=1e-9)
    np.testing.assert_allclose([seen.doubt for seen in online], doubt, atol=1e-9)


def test_the_share_is_that_of_the_peak_and_none_where_it_has_contacts_of_its_own():
    np.testing.assert_allclose(peaked(3.0).contact_level().share, 0.75)
    assert peaked(-0.5).contact_level() is None
    assert peaked(3.0, travel=1e-3).contact_level() is None
    level = peaked(3.0, stribeck_velocity=0.1).contact_level()
    np.testing.assert_allclose(level.fallen(np.array([0.0, 0.1, -0.2, 9.0]), np.zeros(4)),
                               0.25 + 0.75 * np.exp([0.0, -1.0, -2.0, -90.0]))


@pytest.mark.parametrize('name, share', [('load_dependent_friction', [0.75, 0.0, 0.75, 0.75]),
                                         ('coulomb_friction', [0.0, 0.75, 0.75, 0.75])])
def test_where_nobody_knows_the_level_it_does_not_fall(name, share):
    model = peaked(3.0)
    uses, mean = model.uses, model.mean.copy()
    if name == 'coulomb_friction':
        first = next(where for use, where in model.slices() if use.name == name)
        mean[first] = 1e-3 * model.robot.limits.torque[0]
    else:
        uses, mean = (*uses, EffectUse(name, 1)), np.append(mean, 0.05)
    np.testing.assert_allclose(replace(model, uses=uses, mean=mean).contact_level().share, share)


def test_of_no_peak_nothing_is_left_at_speed():
    np.testing.assert_allclose(peaked(1e3).contact_level().share, MOST_PEAK)


def test_a_recording_that_begins_in_motion_begins_at_its_level():
    model, motion = peaked(3.0), warming(25.0)
    moving = motion.part(np.arange(len(motion.dt)) >= np.argmax(np.abs(motion.v[:, 0]) > 0.1) + 5)
    x, _ = motion_input(model.robot, replace(moving), model.presliding_distance(),
                        model.presliding_plastic(), model.contact_level())
    assert abs(x.z[0, 0]) == pytest.approx(1.0, abs=1e-6)
    online = ModelFollower(model).update(next(iter(moving.samples())))
    assert abs(online.z[0]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize('plastic', [0.5, BOTH])
def test_contacts_of_every_kind_side_by_side_are_as_alone(plastic):
    """Where the level falls far faster than they turn, more than both levels are left to go."""
    model, motion = peaked(30.0, stribeck_velocity=0.03), warming(25.0)
    travels, level = np.full(4, 5e-3), model.contact_level()
    alone, _ = motion_input(model.robot, motion, travels, np.full(4, plastic), level)
    mixed, _ = motion_input(model.robot, replace(motion), travels,
                            np.array([0.5, BOTH, 0.5, BOTH]), level)
    stream = ShownStream((travels, np.array([0.5, BOTH, 0.5, BOTH])), level)
    own, online = np.array([0.5, BOTH, 0.5, BOTH]) == plastic, []
    for sample, warmth in zip(motion.samples(), alone.warmth):
        stream.at(course_of(sample), sample.dt, warmth, sample.messages)
        online.append(stream.z)
    np.testing.assert_allclose(mixed.z[:, own], alone.z[:, own], atol=1e-9)
    np.testing.assert_allclose(np.array(online)[:, own], alone.z[:, own], atol=1e-9)


def test_another_way_of_turning_is_followed_up_to_the_same_level():
    residual = find_residual(peaked(2.0), recorded()[:2])
    np.testing.assert_allclose(residual.friction_state(TRAVEL, BOTH), residual.x.z, atol=1e-12)
    other = find_residual(peaked(0.0), recorded()[:2])
    assert np.abs(other.x.z - residual.x.z).max() > 0.05


def test_a_system_tells_whether_its_share_is_that_of_parameters():
    model = peaked(1.0)
    system = System(model.robot, model.uses, recorded()[:1], model.mean)
    assert system.levels_hold(model.uses, model.mean)
    assert system.levels_hold(model.uses, peaked(1.02).mean)
    assert not system.levels_hold(model.uses, peaked(1.5).mean)
    assert not system.levels_hold(model.uses, peaked(0.0).mean)


def test_a_peak_settles_with_the_contacts_that_it_shares(monkeypatch):
    """From figures of the form that a search beside contacts of its own had found."""
    monkeypatch.setitem(TRUE_SHAPE, 'presliding_distance', 3e-3)
    made = Made(four_axes(), recordings=2, plastic=0.5)
    beside = {PRESLIDING: {'presliding_distance': 3.4e-3, 'plastic': 0.8},
              PEAK: {'stribeck_velocity': 0.1, 'exponent': 1.25, 'travel': 1e-3}}
    uses = tuple(replace(u, shape={**u.shape, **beside.get(u.name, {})}) for u in made.uses)
    system = System(made.robot, uses, made.evidence, made.x)
    found = {(u.name, u.joint): u.shape for u in with_turning_fitted(
        system, uses, made.evidence, made.x, made.density, [1, 3], [3])}
    assert found[PEAK, 1]['travel'] == 1e-3 and found[PEAK, 1]['exponent'] == 1.25
    shape = found[PEAK, 3]
    assert np.isinf(shape['travel'])
    assert shape['stribeck_velocity'] == pytest.approx(0.12, rel=0.1)
    # Noise leaves it a tenth.
    assert shape['exponent'] == pytest.approx(1.0, abs=0.2)
    assert found[PRESLIDING, 3]['presliding_distance'] == pytest.approx(3e-3, rel=0.05)
    assert found[PRESLIDING, 3]['plastic'] == pytest.approx(0.5, abs=0.1)
    assert np.isinf(shape['velocity_range']), 'nobody had found that it goes with temperature'
