"""Every hidden effect can be had, costs what its strength says, or is refused with sense."""

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.plant import Plant, read_effects
from hand_load_estimator.plant.arm import Arm
from hand_load_estimator.plant.effects_file import parse_effects
from hand_load_estimator.plant.hidden import EFFECTS
from hand_load_estimator.plant.hidden.reference_motion import ReferenceMotion, WARMER
import numpy as np
from plant_helpers import chain, effects, LOAD, ur10e
import pytest

SEED = 1
LISTED = ('shoulder_lift_joint', 'elbow_joint')
# Teeth change sides only where the gear's torque changes sign, and J2 always carries the arm.
LISTED_FOR = {'backlash': ('shoulder_pan_joint', 'elbow_joint')}
DESIGN_NAMES = {
    'link_inertia', 'rotor_inertia', 'base_tilt', 'gravity_spring', 'cable_drag',
    'coulomb_friction', 'viscous_friction', 'friction_asymmetry', 'stribeck_friction',
    'load_dependent_friction', 'temperature_dependent_viscous_friction',
    'temperature_dependent_coulomb_friction', 'presliding_hysteresis', 'backlash',
    'torque_ripple', 'torque_scale', 'torque_scale_temperature', 'torque_offset', 'time_delay',
    'external_contact', 'load_change'}
# What comes from outside is stated while it lasts: let it last.
ALWAYS = dict.fromkeys(('external_contact', 'load_change'), {'start': 0.0, 'duration': 100.0})


def entry(name, strength):
    """Return an effects file's entry."""
    out = {'name': name, 'strength': strength}
    if EFFECTS[name].per_joint:
        out['joints'] = list(LISTED_FOR.get(name, LISTED))
    if name in ALWAYS:
        out['parameters'] = ALWAYS[name]
    return out


def reference(robot=None):
    robot = robot or ur10e()
    truth = Plant(robot, seed=SEED).truth
    return ReferenceMotion(robot, truth, Arm(robot, truth.links, truth.rotor, truth.gravity))


MOTION = reference()


def reported(temperature, *entries):
    """Return the effort without noise (N, n) and the rigid torque of the motion that came out."""
    robot, motion = ur10e(), MOTION
    plant = Plant(robot, seed=SEED, start_temperature=temperature, rate=200.0,
                  effects=effects(robot, *entries), start_position=motion.q[0])
    rest = np.zeros(6)
    # From rest into the motion within half a second, and to rest at its end.
    time = np.concatenate([motion.time[::10] + 0.5, [motion.time[-1] + 1.0]])
    q, v, a = (np.vstack([rows[::10], last]) for rows, last in
               ((motion.q, motion.q[-1]), (motion.v, rest), (motion.a, rest)))
    plant.set_trajectory(robot.joints, time, q, v, a)
    plant.step_until(1.0)
    effort, rigid = [], []
    for _ in range(1800):
        plant.step()
        effort.append(plant.reported_effort())
        position, velocity, acceleration, _ = plant.state()
        rigid.append(robot.rigid_torque(position, velocity, acceleration)
                     + plant.truth.rotor * acceleration)
    return np.array(effort), np.array(rigid), plant


BASE = {}


def change(name, strength):
    """Return RMS over noise (n,) of what an effect changes, beside the change of the motion."""
    temperature = 25.0 + (WARMER if 'temperature' in name else 0.0)
    if temperature not in BASE:
        BASE[temperature] = reported(temperature)
    effort, rigid, plant = reported(temperature, entry(name, strength))
    difference = effort - BASE[temperature][0]
    if name != 'rotor_inertia':
        difference -= rigid - BASE[temperature][1]
    return np.sqrt(np.mean(difference ** 2, axis=0)) / plant.noise


def test_the_names_of_the_design_are_all_there():
    assert DESIGN_NAMES <= set(EFFECTS)
    assert {'speed_resonance_friction', 'swinging_load', 'saturating_drive'} <= set(EFFECTS)


@pytest.mark.parametrize('name', sorted(set(EFFECTS) - {'load_dependent_friction'}))
def test_an_effect_changes_the_effort_by_strength_times_noise(name):
    strength = 1.0 if name == 'stribeck_friction' else 2.0
    over = change(name, strength)
    if EFFECTS[name].shared:
        assert np.max(over) == pytest.approx(strength, rel=0.2)
    else:
        listed = np.isin(ur10e().joints, entry(name, strength)['joints'])
        np.testing.assert_allclose(over[listed], strength, rtol=0.2)
        assert np.all(over[~listed] < 0.2 * strength)


def test_load_dependent_friction_changes_the_effort_by_strength_times_noise():
    over = change('load_dependent_friction', 1.0)
    np.testing.assert_allclose(over[1:3], 1.0, rtol=0.2)


def test_parameters_are_taken_as_they_are():
    spring = {'name': 'gravity_spring', 'joints': ['elbow_joint'],
              'parameters': {'stiffness': 30.0, 'angle': 0.5}}
    pose = np.array([0.1, -0.4, 0.9, 0.2, 0.3, 0.1])
    one, other = (Plant(ur10e(), seed=SEED, effects=effects(ur10e(), *e), start_position=pose)
                  for e in ((), (spring,)))
    expected = np.zeros(6)
    expected[2] = 30.0 * np.sin(0.9 - 0.5)
    np.testing.assert_allclose(other.state()[3] - one.state()[3], expected, atol=1e-6)


def test_a_tilted_base_changes_gravity_by_the_angle():
    plant = Plant(ur10e(), effects=effects(
        ur10e(), {'name': 'base_tilt', 'parameters': {'angle': 0.1}}))
    gravity = plant.truth.gravity
    assert np.linalg.norm(gravity) == pytest.approx(9.81)
    assert np.arccos(-gravity[2] / 9.81) == pytest.approx(0.1)


def test_a_delay_shows_the_torque_of_an_earlier_moment():
    late = {'name': 'time_delay', 'parameters': {'delay': 0.0205}}
    plant = Plant(ur10e(), seed=SEED, effects=effects(ur10e(), late))
    plant.attach(LOAD)
    true, shown = [], []
    for _ in range(100):
        plant.step()
        true.append(plant.state()[3])
        shown.append(plant.reported_effort())
    true, shown = np.array(true), np.array(shown)
    # 20.5 ms is a quarter of the way from ten samples ago to eleven samples ago.
    np.testing.assert_allclose(shown[40:], 0.75 * true[30:-10] + 0.25 * true[29:-11], atol=0.3)
    assert np.max(np.abs(shown - true)) > 5.0


def test_a_contact_is_bounded_in_time():
    push = {'name': 'external_contact', 'parameters': {'force': 60.0, 'direction': [0, 0, -1],
                                                       'start': 1.0, 'duration': 0.5}}
    one, other = (Plant(ur10e(), seed=SEED, effects=effects(ur10e(), *e))
                  for e in ((), (push,)))
    seen = {}
    for t in (0.9, 1.4, 6.0):
        one.step_until(t)
        other.step_until(t)
        seen[t] = np.abs(other.state()[3] - one.state()[3])[1]
    assert seen[0.9] < 1e-9 and seen[1.4] > 40.0 and seen[6.0] < 15.0


def held_torque(plant, robot, at):
    """Return the torque (n,) [Nm] through the gears at rest, beside what the links weigh."""
    plant.step_until(at)
    q = plant.state()[0]
    return plant.state()[3] - plant.friction_torque() \
        - robot.rigid_torque(q, np.zeros(6), np.zeros(6))


@pytest.mark.parametrize('load', [None, LOAD])
def test_a_load_change_is_bounded_in_time_and_weighs_what_it_says(load):
    robot, pose = ur10e(), np.array([0.3, -0.8, 1.1, 0.2, 0.4, 0.1])
    ball = {'name': 'load_change', 'parameters': {'mass': 0.5, 'com': [0.0, 0.02, 0.1],
                                                  'start': 1.0, 'duration': 3.0}}
    one, other = (Plant(robot, seed=SEED, load=load, start_position=pose,
                        effects=effects(robot, *e)) for e in ((), (ball,)))
    more = {t: held_torque(other, robot, t) - held_torque(one, robot, t)
            for t in (0.9, 3.9, 9.0)}
    zero = np.zeros(6)
    expected = robot.load_regressor(pose, zero, zero) @ LoadParameters(
        0.5, [0.0, 0.02, 0.1], 5e-4 * np.eye(3)).to_products()
    assert np.max(np.abs(more[0.9])) < 1e-9 and np.abs(expected).max() > 3.0
    np.testing.assert_allclose(more[3.9], expected, atol=0.05)
    assert np.max(np.abs(more[9.0])) < 0.05


def test_two_load_changes_hang_together_where_they_overlap():
    robot = ur10e()
    balls = [{'name': 'load_change', 'parameters': {
        'mass': mass, 'com': [0.0, 0.0, 0.1], 'start': start, 'duration': 2.0}}
        for mass, start in ((0.5, 1.0), (1.0, 2.0))]
    plant = Plant(robot, seed=SEED, load=LOAD, effects=effects(robot, *balls))
    body = plant._arm._model.body('load')
    masses = []
    for t in (0.5, 1.5, 2.5, 3.5, 4.5):
        plant.step_until(t)
        masses.append(body.mass[0] - LOAD.mass)
    np.testing.assert_allclose(masses, [0.0, 0.5, 1.5, 1.0, 0.0], atol=1e-9)


def test_effects_do_not_change_what_the_seed_draws():
    one = Plant(ur10e(), seed=SEED).truth
    other = Plant(ur10e(), seed=SEED, effects=effects(
        ur10e(), entry('torque_ripple', 1.0), entry('torque_offset', 1.0))).truth
    np.testing.assert_array_equal(one.friction.coulomb, other.friction.coulomb)
    np.testing.assert_array_equal(one.links, other.links)


def test_effects_together_on_another_arm_stay_finite():
    robot = chain('z', 'y', 'y', 'x', 'z', 'y', 's')
    names = ('gravity_spring', 'cable_drag', 'torque_ripple', 'time_delay', 'backlash',
             'presliding_hysteresis', 'swinging_load', 'base_tilt', 'speed_resonance_friction')
    plant = Plant(robot, seed=2, load=LOAD, effects=effects(
        robot, *({'name': name, 'strength': 0.3,
                  **({'joints': ['j0', 'j2']} if EFFECTS[name].per_joint
                     and name != 'backlash' else {}),
                  **({'joints': ['j1']} if name == 'backlash' else {})} for name in names)))
    for k in range(6):
        goal = 0.4 * (-1.0) ** k * np.ones((1, 7))
        plant.set_trajectory(robot.joints, [0.5], goal, np.zeros((1, 7)), np.zeros((1, 7)))
        plant.step_until(0.5 * (k + 1))
        assert np.all(np.isfinite(plant.measure()))


REFUSED = {
    'unknown name': ({'name': 'magic', 'strength': 1.0}, 'magic.*torque_ripple'),
    'unknown joint': ({'name': 'torque_ripple', 'joints': ['j9'], 'strength': 1.0},
                      'j9.*shoulder_pan_joint'),
    'joints of the whole arm': ({'name': 'base_tilt', 'joints': ['elbow_joint'],
                                 'strength': 1.0}, 'whole arm'),
    'neither': ({'name': 'torque_ripple'}, 'strength'),
    'both': ({'name': 'torque_ripple', 'strength': 1.0, 'parameters': {'torque': 1.0}},
             'not both'),
    'unknown parameter': ({'name': 'torque_ripple', 'parameters': {'torque': 1.0, 'x': 1.0}},
                          'know x.*periods .per turn.'),
    'wrong count': ({'name': 'torque_ripple', 'joints': ['elbow_joint'],
                     'parameters': {'torque': [1.0, 2.0]}}, 'list of 1'),
    'negative strength': ({'name': 'torque_ripple', 'strength': -1.0}, 'strength'),
    'unknown key': ({'name': 'torque_ripple', 'strenght': 1.0}, 'strength'),
}


@pytest.mark.parametrize('case', REFUSED)
def test_a_wrong_entry_is_refused_with_a_sentence(case):
    wrong, sentence = REFUSED[case]
    with pytest.raises(ConfigurationError, match=sentence):
        parse_effects([wrong], ur10e())


def test_a_strength_out_of_reach_is_refused_with_what_is_in_reach():
    # J5 of an upright UR10e carries next to no torque for friction to grow with.
    wrong = {'name': 'load_dependent_friction', 'joints': ['wrist_2_joint'], 'strength': 50.0}
    with pytest.raises(ConfigurationError, match='strength up to'):
        Plant(ur10e(), effects=effects(ur10e(), wrong))


def test_a_file_is_read(tmp_path):
    path = tmp_path / 'effects.yaml'
    path.write_text('effects:\n- {name: torque_offset, joints: [elbow_joint], strength: 3}\n')
    request, = read_effects(path, ur10e())
    assert (request.name, request.joints, request.strength) == ('torque_offset', (2,), 3.0)
    plant = Plant(ur10e(), effects=(request,))
    np.testing.assert_allclose(plant.truth.effort_offset, [0, 0, 2.7, 0, 0, 0])
    path.write_text('effects: none\n')
    with pytest.raises(ConfigurationError, match='list'):
        read_effects(path, ur10e())
