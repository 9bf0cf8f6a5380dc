"""Travels over which friction turns go with the friction that temperature leaves."""

from dataclasses import replace
from functools import lru_cache

from core_helpers import effect_uses, four_axes, true_parameters
from effect_helpers import DT, model_with, waves
from hand_load_estimator.plant.difficulty import DEFAULT
from hand_load_estimator.plant.friction import draw_friction, friction_along
import numpy as np
from plant_helpers import ur10e
import pytest
from test_effects_online import filtered

from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.identification.regression_system import System
from hand_load_estimator.identification.turning_fit import with_turning_fitted
from hand_load_estimator.motion import Motion
from hand_load_estimator.residual.add import identified_again
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.torque.columns import EffectUse, torque_columns
from hand_load_estimator.torque.contact_level import ContactLevel, LEAST, MOST
from hand_load_estimator.torque.model_follower import ModelFollower
from hand_load_estimator.torque.motion_inputs import motion_input
from hand_load_estimator.torque.presliding import Turning
from hand_load_estimator.torque_model import Residuals, TorqueModel

FALL = 'temperature_dependent_coulomb_friction'
COLD, WARM = 15.0, 45.0


def warming(celsius):
    """Return the Motion of 3 s whose joints have temperatures (N,) or a single one [degC]."""
    motion = Motion.of(filtered(3.0, 125.0))
    return replace(motion, temperature=np.broadcast_to(
        np.reshape(celsius, (-1, 1)), motion.q.shape).copy())


def falling(share, knee=np.inf):
    """Return a TorqueModel whose Coulomb friction falls by a share [1/K] of its level."""
    model = model_with(four_axes(), (FALL,), {FALL: (0.0,)})
    level = model.friction_level()
    mean = model.mean.copy()
    for use, where in model.slices():
        if use.name == FALL:
            mean[where] = -share * level[use.joint]
    uses = tuple(replace(u, shape={**u.shape, 'knee': knee}) if u.name == FALL else u
                 for u in model.uses)
    return replace(model, mean=mean, uses=uses)


def warming_level(slope):
    """Return the ContactLevel of joints without a peak."""
    n = len(slope)
    return ContactLevel(slope, np.full(n, np.inf), np.zeros(n), np.ones((3, n)))


def test_travels_fall_with_friction_as_far_as_its_knee():
    level = falling(0.02, knee=10.0).contact_level()
    np.testing.assert_allclose(level.warmed(np.full(4, 5.0)), 0.9)
    np.testing.assert_allclose(level.warmed(np.full((3, 4), 30.0)), 0.8)
    np.testing.assert_allclose(level.warmed(np.full(4, -10.0)), 1.2)


def test_the_level_is_that_of_a_joint_that_turns():
    """Where contacts bend up to Coulomb friction and the Stribeck peak, a third of that falls."""
    model = model_with(four_axes(), (FALL, 'stribeck_friction'),
                       {FALL: (0.0,), 'stribeck_friction': (0.0, 0.0)})
    mean = model.mean.copy()
    for use, where in model.slices():
        share = {'coulomb_friction': 0.02, 'stribeck_friction': 0.01, FALL: -0.001}.get(use.name)
        if share is not None:
            mean[where.start] = share * model.robot.limits.torque[use.joint]
    level = replace(model, mean=mean).contact_level()
    np.testing.assert_allclose(level.warmed(np.full(4, 10.0)), 2.0 / 3.0)


def test_no_line_foretells_a_travel_of_nothing():
    level = warming_level(np.array([-0.1, 0.5]))
    np.testing.assert_allclose(level.warmed(np.full(2, 30.0)), [LEAST, MOST])


def test_without_temperature_or_friction_travels_stay():
    assert falling(0.0).contact_level() is None
    assert model_with(four_axes(), ('torque_offset',), {'torque_offset': (0.1,)}
                      ).contact_level() is None
    model = falling(0.02)
    mean = model.mean.copy()
    for use, where in model.slices():
        if use.name in ('coulomb_friction', 'stribeck_friction'):
            mean[where] = 0.0
    assert replace(model, mean=mean).contact_level() is None


def test_half_the_friction_turns_over_half_the_travel():
    model = falling(0.025)
    distance, plastic = model.presliding_distance(), np.full(4, 0.8)
    reference = model.robot.reference_temperature
    found, doubt = motion_input(model.robot, warming(reference + 20.0), distance, plastic,
                                model.contact_level())
    half, doubted = motion_input(model.robot, warming(reference), 0.5 * distance, plastic)
    np.testing.assert_allclose(found.z, half.z, atol=1e-12)
    np.testing.assert_allclose(doubt, doubted, atol=1e-12)
    whole, _ = motion_input(model.robot, warming(reference), distance, plastic)
    assert np.abs(found.z - whole.z).max() > 0.05


def test_it_is_followed_online_as_along_a_recording():
    model = falling(0.02, knee=12.0)
    motion = warming(25.0)
    motion = warming(np.linspace(COLD, WARM, len(motion.dt)))
    x, doubt = motion_input(model.robot, motion, model.presliding_distance(),
                            model.presliding_plastic(), model.contact_level())
    follower = ModelFollower(model)
    online = [follower.update(sample) for sample in motion.samples()]
    np.testing.assert_allclose([seen.z for seen in online], x.z, atol=1e-9)
    np.testing.assert_allclose([seen.doubt for seen in online], doubt, atol=1e-9)


@pytest.mark.parametrize('celsius', [COLD, WARM])
def test_bristles_of_one_stiffness_turn_so(celsius):
    """Against the friction of the plant: what it foretells of it, and what it is without."""
    figures = draw_friction(ur10e(), DEFAULT, np.random.default_rng(3))
    n = len(figures.coulomb)
    figures = replace(figures, static=np.zeros(n), asymmetry=np.zeros(n),
                      coulomb_slope=-0.02 * figures.coulomb, viscous_rest=np.zeros(n),
                      viscous_part=np.zeros(n))
    t = np.arange(0.0, 6.0, 5e-4)
    q, v = 0.01 * np.sin(t)[:, None], 0.01 * np.cos(t)[:, None]

    def turning(kelvin):
        level = figures.at(np.full(n, 25.0 + kelvin))[0]
        friction = friction_along(figures, np.tile(v, n), np.zeros((len(t), n)),
                                  np.full(n, 25.0 + kelvin), 5e-4)
        return (friction / level)[::10]
    told = turning(0.0)
    travels, contacts = np.geomspace(2e-4, 4e-3, 30), Turning(np.full(n, 0.5))

    def model(travel):
        out, z = [], told[0]
        for way in np.diff(q[::10], axis=0):
            z = contacts.turned(z, np.repeat(way, n), travel)
            out.append(z)
        return np.array(out)
    late = slice(300, None)
    errors = np.array([np.abs(model(np.full(n, s)) - told[1:])[late].mean(axis=0)
                       for s in travels])
    travel = travels[errors.argmin(axis=0)]
    seen = turning(celsius - 25.0)[1:]
    grown = travel * warming_level(np.full(n, -0.02)).warmed(celsius - 25.0)
    left = [np.sqrt(np.mean((model(s) - seen)[late] ** 2)) for s in (grown, travel)]
    assert left[0] < 0.4 * left[1]


# Identification and diagnosis.

NAMES = ('coulomb_friction', 'viscous_friction', 'presliding_hysteresis')
TRAVEL, SHARE = 4e-3, 0.025


def slow_arm(share=SHARE):
    """Return a right TorqueModel whose friction turns over a long way, longer when cold."""
    robot = four_axes()
    uses = effect_uses(robot, NAMES) + tuple(EffectUse(FALL, j) for j in range(robot.n))
    uses = tuple(replace(u, shape={**u.shape, 'presliding_distance': TRAVEL})
                 if u.name == 'presliding_hysteresis' else u for u in uses)
    mean = np.append(true_parameters(robot, uses[:-robot.n]), np.zeros(robot.n))
    noise = 2e-3 * robot.limits.torque
    model = TorqueModel(robot, uses, False, mean, np.zeros((len(mean),) * 2), Residuals(
        noise, noise ** 2 * DT, np.zeros((robot.n, 3))), (RecordingMark('made up'),), (15.0, 45.0))
    mean[-robot.n:] = -share * model.friction_level()
    return model


@lru_cache(None)
def recorded():
    """Return the Evidence of that arm, each temperature twice."""
    model, rng, out = slow_arm(), np.random.default_rng(2), []
    for celsius in 2 * (COLD, 35.0, WARM):
        motion = waves(model.robot, rng, 15.0, celsius)
        x, _ = motion_input(model.robot, motion, model.presliding_distance(),
                            level=model.contact_level())
        torque = torque_columns(model.robot, model.layout, x) @ model.mean
        out.append(Evidence(f'run {len(out)}', motion,
                            torque + rng.normal(size=torque.shape) * model.noise))
    return out


def left_while_turning(model):
    """Return the RMS (n,) of what a model leaves while friction turns, in times the noise."""
    found = find_residual(model, recorded(), cut=False)
    turning = (np.abs(found.x.z) < 0.95) & (np.abs(found.x.v) > 0.01)
    square = np.where(turning, found.residual, 0.0) ** 2
    return np.sqrt(square.sum(axis=0) / turning.sum(axis=0)) / slow_arm().noise


def test_a_right_model_leaves_nothing_while_friction_turns():
    assert (left_while_turning(slow_arm()) < 1.1).all()
    without = replace(slow_arm(), uses=slow_arm(0.0).uses, mean=slow_arm(0.0).mean)
    assert (left_while_turning(without) > 2.0).all()


def test_identification_finds_the_travel_of_the_reference_temperature():
    found = identify(four_axes(), recorded(), [*NAMES, FALL])
    assert (left_while_turning(found) < 1.1).all()
    np.testing.assert_allclose(found.presliding_distance(), TRAVEL, rtol=0.26)


def test_a_fall_that_is_new_makes_travels_new():
    old = slow_arm(0.0)
    std = 0.01 * np.abs(old.mean)
    std[-4:] = 1e-4 * old.noise
    old = replace(old, covariance=np.diag(std ** 2))
    found = identified_again(old, old.uses, recorded(), {(FALL, j) for j in range(4)})
    assert (left_while_turning(found) < 1.1).all()
    # With the travels of before up to 1.018 times the noise is stated.
    assert (found.residuals.rmse < 1.012 * old.noise).all()


def test_a_system_tells_whether_its_travels_are_those_of_parameters():
    right, before = slow_arm(), slow_arm(0.0)
    system = System(right.robot, right.uses, recorded(), before.mean)
    assert system.levels_hold(before.uses, before.mean)
    assert not system.levels_hold(right.uses, right.mean)
    assert System(right.robot, right.uses, recorded(), right.mean).levels_hold(
        right.uses, slow_arm(0.999 * SHARE).mean)


def test_the_way_of_turning_that_is_right_stays():
    model = slow_arm()
    system = System(model.robot, model.uses, recorded(), model.mean)
    uses = with_turning_fitted(system, model.uses, recorded(), model.mean,
                               model.noise ** 2 * DT, range(4))
    for use in uses:
        if use.name == 'presliding_hysteresis':
            assert use.shape['presliding_distance'] == pytest.approx(TRAVEL, rel=0.05)


@pytest.mark.parametrize('name', ['load_dependent_friction', 'coulomb_friction'])
def test_where_nobody_knows_how_the_level_falls_travels_stay(name):
    model = slow_arm()
    if name == 'coulomb_friction':
        mean = model.mean.copy()
        for use, where in model.slices():
            if use.name == name:
                mean[where] = 1e-3 * model.robot.limits.torque[use.joint]
        assert replace(model, mean=mean).contact_level() is None
        return
    uses = (*model.uses, EffectUse(name, 1))
    level = replace(model, uses=uses, mean=np.append(model.mean, 0.05)).contact_level()
    np.testing.assert_allclose(level.warmed(np.full(4, 10.0)), [0.75, 1.0, 0.75, 0.75])
