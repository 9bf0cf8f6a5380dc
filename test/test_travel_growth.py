"""Travels over which friction turns go with the friction that temperature leaves."""

from dataclasses import replace

from core_helpers import four_axes
from effect_helpers import model_with
from hand_load_estimator.plant.difficulty import DEFAULT
from hand_load_estimator.plant.friction import draw_friction, friction_along
import numpy as np
from plant_helpers import ur10e
import pytest
from test_effects_online import filtered

from hand_load_estimator.motion import Motion
from hand_load_estimator.torque.model_follower import ModelFollower
from hand_load_estimator.torque.motion_inputs import motion_input
from hand_load_estimator.torque.presliding import Turning
from hand_load_estimator.torque.travel_growth import LEAST, MOST, TravelGrowth

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


def test_travels_fall_with_friction_as_far_as_its_knee():
    growth = falling(0.02, knee=10.0).travel_growth()
    np.testing.assert_allclose(growth(np.full(4, 5.0)), 0.9)
    np.testing.assert_allclose(growth(np.full((3, 4), 30.0)), 0.8)
    np.testing.assert_allclose(growth(np.full(4, -10.0)), 1.2)


def test_no_line_foretells_a_travel_of_nothing():
    growth = TravelGrowth(np.array([-0.1, 0.5]), np.full(2, np.inf))
    np.testing.assert_allclose(growth(np.full(2, 30.0)), [LEAST, MOST])


def test_without_temperature_or_friction_travels_stay():
    assert falling(0.0).travel_growth() is None
    assert model_with(four_axes(), ('torque_offset',), {'torque_offset': (0.1,)}
                      ).travel_growth() is None
    model = falling(0.02)
    mean = model.mean.copy()
    for use, where in model.slices():
        if use.name in ('coulomb_friction', 'stribeck_friction'):
            mean[where] = 0.0
    assert replace(model, mean=mean).travel_growth() is None


def test_half_the_friction_turns_over_half_the_travel():
    model = falling(0.025)
    distance, power = model.presliding_distance(), np.full(4, 2.0)
    reference = model.robot.reference_temperature
    found, doubt = motion_input(model.robot, warming(reference + 20.0), distance, power,
                                model.travel_growth())
    half, doubted = motion_input(model.robot, warming(reference), 0.5 * distance, power)
    np.testing.assert_allclose(found.z, half.z, atol=1e-12)
    np.testing.assert_allclose(doubt, doubted, atol=1e-12)
    whole, _ = motion_input(model.robot, warming(reference), distance, power)
    assert np.abs(found.z - whole.z).max() > 0.05


def test_it_is_followed_online_as_along_a_recording():
    model = falling(0.02, knee=12.0)
    motion = warming(25.0)
    motion = warming(np.linspace(COLD, WARM, len(motion.dt)))
    x, doubt = motion_input(model.robot, motion, model.presliding_distance(),
                            model.presliding_power(), model.travel_growth())
    follower = ModelFollower(model)
    online = [follower.update(sample) for sample in motion.samples()]
    np.testing.assert_allclose([seen.z for seen in online], x.z, atol=1e-9)
    np.testing.assert_allclose([seen.doubt for seen in online], doubt, atol=1e-9)


@pytest.mark.parametrize('celsius', [COLD, WARM])
def test_bristles_of_one_stiffness_turn_so(celsius):
    """Against the friction of the plant: what growth foretells of it, and what it is without."""
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
    travels, powers = np.geomspace(2e-4, 4e-3, 30), Turning(np.full(n, 1.6))

    def model(travel):
        out, z = [], told[0]
        for way in np.diff(q[::10], axis=0):
            z = powers.turned(z, np.repeat(way, n), travel)
            out.append(z)
        return np.array(out)
    late = slice(300, None)
    errors = np.array([np.abs(model(np.full(n, s)) - told[1:])[late].mean(axis=0)
                       for s in travels])
    travel = travels[errors.argmin(axis=0)]
    seen = turning(celsius - 25.0)[1:]
    grown = travel * TravelGrowth(np.full(n, -0.02), np.full(n, np.inf))(celsius - 25.0)
    left = [np.sqrt(np.mean((model(s) - seen)[late] ** 2)) for s in (grown, travel)]
    assert left[0] < 0.4 * left[1]
