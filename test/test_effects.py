"""Effects: columns of the stated shape and physics, through model files and online alike."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import (effect_uses, exact_model, four_axes, message_noise, messages,
                          true_parameters)
import numpy as np
import pytest

from hand_load_estimator.effects import EFFECTS, EffectInput
from hand_load_estimator.identification import Evidence, System
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.model_file import model_content, read_model, write_model
from hand_load_estimator.model_follower import ModelFollower
from hand_load_estimator.motion import Motion, MotionFilter
from hand_load_estimator.play import play_along
from hand_load_estimator.torque_columns import (as_reported, ColumnLayout, effect_slices,
                                                EffectUse, lateness, motion_input,
                                                parameter_count, torque_columns)
from hand_load_estimator.torque_model import Residuals, TorqueModel

DT = 0.02
LOAD = LoadParameters(2.0, [0.02, -0.03, 0.1], 0.01 * np.eye(3))
ALWAYS = ('q', 'v', 'a', 'warmth', 'z')
# Values of the effects that depend on torques, large enough to be seen in one.
BOUND = {'base_tilt': (0.02, -0.03), 'load_dependent_friction': (0.05,),
         'backlash': (0.8,), 'torque_scale': (0.04,),
         'torque_scale_temperature': (2e-3,), 'time_delay': (0.8,)}


def inputs(n=4, count=60, seed=0):
    """Return an EffectInput of random numbers with everything an effect may read."""
    rng, shape = np.random.default_rng(seed), (60, n)
    torque, dt = np.cumsum(rng.normal(size=shape), axis=0), np.full(count, DT)
    return EffectInput(
        rng.uniform(-2, 2, shape), rng.uniform(-1, 1, shape), rng.uniform(-3, 3, shape),
        rng.uniform(-10, 25, shape), rng.uniform(-1, 1, shape), 10.0 * rng.normal(size=shape),
        torque, rng.normal(size=shape), rng.normal(size=(*shape, 2)), lateness(torque, dt),
        play_along(torque, 2.0 + np.zeros(shape), np.full(n, 2.0), dt))


def shapes_of(effect, count):
    """Return a different value of each shape parameter for so many joints."""
    return {s.name: np.array([s.grid[k % len(s.grid)] if s.grid else 40.0 + 7.0 * k
                              for k in range(count)])
            for s in effect.shapes}


def of_joint(effect, x, j, value=None):
    shape = {s.name: s.default if value is None else value for s in effect.shapes}
    return effect.columns(x, j, shape)


# The columns.

@pytest.mark.parametrize('name', EFFECTS)
def test_joints_one_by_one_and_together_have_the_same_columns(name):
    effect, x, joints = EFFECTS[name], inputs(), np.array([3, 0, 2])
    shapes = shapes_of(effect, len(joints))
    together = effect.columns(x, joints, shapes)
    assert together.shape == (60, len(joints), len(effect.parameters))
    assert len(effect.prior_std) == len(effect.parameters)
    for k, j in enumerate(joints):
        alone = effect.columns(x, j, {s: float(values[k]) for s, values in shapes.items()})
        assert alone.shape == (60, len(effect.parameters))
        np.testing.assert_allclose(together[:, k], alone, rtol=1e-12, atol=1e-15)
        assert np.abs(alone).max() > 0.0


@pytest.mark.parametrize('name', EFFECTS)
def test_an_effect_reads_what_it_says_and_nothing_else(name):
    effect, x = EFFECTS[name], inputs()
    told = {field: getattr(x, field) for field in (*ALWAYS, *effect.needs)}
    np.testing.assert_array_equal(of_joint(effect, EffectInput(**told), 1),
                                  of_joint(effect, x, 1))
    for need in effect.needs:
        if need == 'warmth':
            cold = of_joint(effect, replace(x, warmth=np.zeros_like(x.q)), 1)
            assert not cold.any()
            continue
        with pytest.raises((TypeError, AttributeError)):
            of_joint(effect, EffectInput(**{**told, need: None}), 1)


@pytest.mark.parametrize('name', EFFECTS)
def test_another_joint_changes_nothing(name):
    """Effects of one joint read that joint only."""
    effect, x, other = EFFECTS[name], inputs(), inputs(seed=1)
    mixed = {}
    for field in EffectInput.__dataclass_fields__:
        if field not in ('late', 'play'):
            mixed[field] = getattr(other, field).copy()
            mixed[field][:, 2] = getattr(x, field)[:, 2]
    dt = np.full(60, DT)
    mixed = EffectInput(**mixed, late=lateness(mixed['drive'], dt),
                        play=play_along(mixed['drive'], 2.0 + np.zeros((60, 4)), np.full(4, 2.0),
                                        dt))
    np.testing.assert_allclose(of_joint(effect, mixed, 2), of_joint(effect, x, 2))
    assert of_joint(effect, x, 1).shape == of_joint(effect, x, 2).shape


def test_joints_may_be_declared_in_any_order():
    x, n = inputs(), 4
    uses = [EffectUse(name, joint, EFFECTS[name].default_shape())
            for name in ('viscous_friction', 'stribeck_friction') for joint in (2, 0, 3, 1)]
    columns = np.zeros((60, n, parameter_count(n, uses)))
    ColumnLayout(n, uses).fill(columns, x)
    for use, where in effect_slices(n, uses):
        np.testing.assert_array_equal(columns[:, use.joint, where],
                                      use.effect.columns(x, use.joint, use.shape))
    assert np.count_nonzero(columns) == 60 * (4 + 8)


def test_time_delay_is_the_torque_shifted():
    """A delay of whole samples is exactly the torque of those samples ago; others lie between."""
    t = np.arange(80) * DT
    torque = np.stack([np.sin(3.0 * t), 5.0 * np.cos(2.0 * t)], axis=1)
    late = lateness(torque, np.full(80, DT))
    x = replace(inputs(2, 80), late=late, q=torque)
    effect = EFFECTS['time_delay']
    for k in (1, 3):
        column = of_joint(effect, x, 1, k * DT)[:, 0]
        np.testing.assert_allclose(column[k:], torque[:-k, 1] - torque[k:, 1], atol=1e-12)
    # Before the first sample the torque stood still.
    np.testing.assert_allclose(of_joint(effect, x, 1, 3 * DT)[:3, 0],
                               torque[0, 1] - torque[:3, 1])
    between = of_joint(effect, x, 0, 0.033)[2:, 0]
    np.testing.assert_allclose(between, (np.sin(3.0 * (t - 0.033)) - np.sin(3.0 * t))[2:],
                               atol=2e-3)
    assert effect.derived((0.5,), {'shift': 0.03}) == {'delay': (pytest.approx(0.015), 's')}


def test_lateness_goes_on_from_what_was_before():
    torque = np.random.default_rng(0).normal(size=(40, 2))
    dt = np.random.default_rng(1).uniform(0.01, 0.03, 40)
    whole = lateness(torque, dt)(0.045)
    part = lateness(torque[30:], dt[30:], (torque[:30], dt[:30]))(0.045)
    np.testing.assert_allclose(part, whole[30:], atol=1e-12)


def test_torque_that_stands_still_is_not_late():
    """Without times (planning, sampling of poses) no row is the past of another."""
    torque = np.random.default_rng(0).normal(size=(5, 3))
    np.testing.assert_array_equal(lateness(torque, None)(0.02), np.zeros((5, 3)))


def turned(gravity, vector):
    """Return gravity (3,) turned by a rotation vector [rad]."""
    angle = np.linalg.norm(vector)
    axis = np.asarray(vector) / angle
    return gravity * np.cos(angle) + np.cross(axis, gravity) * np.sin(angle) \
        + axis * (axis @ gravity) * (1.0 - np.cos(angle))


@pytest.mark.parametrize('gravity', [(0.0, 0.0, -9.81), (0.0, 3.0, -9.3), (9.81, 0.0, 0.0)])
def test_base_tilt_is_the_torque_of_turned_gravity(gravity):
    """By any angle, on floor and wall, of the links and of a load alike."""
    rng, gravity = np.random.default_rng(3), np.array(gravity)
    q, zero = rng.uniform(-1.5, 1.5, (20, 4)), np.zeros(4)
    robot = four_axes(gravity=gravity.tolist())
    axes = robot.tilt_axes()
    # Turning gravity about itself would change nothing.
    np.testing.assert_allclose(axes @ gravity, 0.0, atol=1e-9)
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-12)
    x = EffectInput(q, q, q, np.zeros_like(q), np.sign(q))
    for angles in 0.3 * np.array([0.6, -0.8]), np.array([1e-4, 0.0]):
        model = model_with(robot, ('base_tilt',), {'base_tilt': tuple(angles)})
        columns = torque_columns(robot, model.layout, x, model.mean)[:, :, -2:]
        leaning = four_axes(gravity=turned(gravity, angles @ axes).tolist())
        change = np.array([leaning.rigid_torque(row, zero, zero)
                           - robot.rigid_torque(row, zero, zero) for row in q])
        assert np.abs(change).max() > 1e-4
        np.testing.assert_allclose(columns @ angles, change, rtol=1e-9, atol=1e-9)
        loads = [leaning.load_regressor(row, zero, zero) - robot.load_regressor(row, zero, zero)
                 for row in q]
        np.testing.assert_allclose(
            [np.einsum('a,ajk->jk', angles, robot.tilted_load_columns(row, angles)) for row in q],
            loads, rtol=1e-9, atol=1e-9)


def test_a_level_base_leans_about_its_x_and_y():
    np.testing.assert_allclose(np.abs(four_axes().tilt_axes()), np.eye(3)[:2], atol=1e-12)


def test_the_robot_keeps_its_gravity():
    robot = four_axes()
    q, zero = np.array([0.3, 0.5, -0.7, 0.2]), np.zeros(4)
    before = robot.rigid_torque(q, zero, zero)
    robot.tilt_regressor(q, robot.nominal_links)
    np.testing.assert_array_equal(robot.rigid_torque(q, zero, zero), before)


def test_a_spring_of_stiffness_and_angle():
    effect, x = EFFECTS['gravity_spring'], inputs()
    torque = 7.0 * np.sin(x.q[:, 1] - 0.4)
    values, *_ = np.linalg.lstsq(of_joint(effect, x, 1), torque, rcond=None)
    np.testing.assert_allclose(of_joint(effect, x, 1) @ values, torque, atol=1e-9)
    derived = effect.derived(values, {})
    assert derived['stiffness'] == (pytest.approx(7.0), 'Nm')
    assert derived['angle'] == (pytest.approx(0.4), 'rad')


def test_a_cable_is_no_whole_period():
    """A smooth pull is fitted well, many periods per turn are not."""
    x = inputs(count=60)
    q, columns = x.q[:, 1], of_joint(EFFECTS['cable_drag'], x, 1)

    def left(torque):
        fit, *_ = np.linalg.lstsq(columns, torque, rcond=None)
        return np.std(torque - columns @ fit) / np.std(torque)
    assert left(np.tanh(q / 1.5)) < 0.05 and left(np.sin(20.0 * q)) > 0.7


def test_friction_of_a_loaded_gear_is_against_the_motion():
    effect, x = EFFECTS['load_dependent_friction'], inputs()
    for gear in (20.0, -20.0):
        sliding = replace(x, z=np.sign(x.v), gear=np.full_like(x.v, gear))
        np.testing.assert_allclose(of_joint(effect, sliding, 1)[:, 0], 20.0 * np.sign(x.v[:, 1]))
        # On the way between the levels it is as far as the other friction is.
        turning = replace(sliding, z=0.3 * np.sign(x.v))
        np.testing.assert_allclose(of_joint(effect, turning, 1)[:, 0], 6.0 * np.sign(x.v[:, 1]))


def test_unequal_friction_levels_are_gone_between_them():
    """Contacts bent forwards hold C + A, backwards C - A, unbent ones nothing; an offset stays."""
    x, level, unequal = inputs(), 3.0, 1.2
    moving = replace(x, z=np.sign(x.v))
    held = replace(x, v=np.zeros_like(x.v))
    asymmetry = EFFECTS['friction_asymmetry']
    for at in (moving, held):
        torque = level * at.z[:, 2] + unequal * of_joint(asymmetry, at, 2)[:, 0]
        expected = np.where(at.z[:, 2] > 0.0, level + unequal, level - unequal) * at.z[:, 2]
        np.testing.assert_allclose(torque, expected, atol=1e-12)
    unbent = replace(held, z=np.zeros_like(x.z))
    assert not of_joint(asymmetry, unbent, 2).any()
    assert (of_joint(EFFECTS['torque_offset'], unbent, 2) == 1.0).all()


def test_friction_is_not_seen_behind_the_gear():
    seen = {e.name for e in EFFECTS.values() if e.in_link_torque}
    assert not [name for name in seen if 'friction' in name or name in (
        'rotor_inertia', 'presliding_hysteresis', 'backlash')]
    assert {'base_tilt', 'gravity_spring', 'cable_drag', 'torque_scale', 'time_delay'} <= seen


# Whole models.

def model_with(robot, names, values, shape=None):
    """Return a TorqueModel of nominal links, plain friction and effects of stated values."""
    plain = effect_uses(robot)
    added = tuple(EffectUse(name, j, {s.name: (shape or {}).get(s.name, s.default)
                                      for s in EFFECTS[name].shapes})
                  for name in names for j in range(robot.n)
                  if not (EFFECTS[name].whole_arm and j))
    uses = added if not values else plain + added
    mean = np.zeros(parameter_count(robot.n, uses))
    mean[:10 * robot.n] = robot.nominal_links
    if values:
        mean[:parameter_count(robot.n, plain)] = true_parameters(robot, plain)
    for use, where in effect_slices(robot.n, uses):
        if use.name in values:
            mean[where] = values[use.name]
    noise = message_noise(robot)
    return TorqueModel(robot, uses, False, mean, np.diag((0.01 * mean) ** 2), Residuals(
        noise, noise ** 2 * DT, np.zeros((robot.n, 3))), ('made up',), (15.0, 45.0))


def filtered(seconds, rate):
    """Return MotionSamples of a motion at a rate [Hz] through the filter, warm joints."""
    motion = MotionFilter(4)
    for joint in range(4):
        motion.set_temperature(joint, 37.0)
    found = [motion.update(m.stamp, m.position, m.velocity, m.effort) for m in messages(
        exact_model('four'), LoadParameters(), seconds, rate=rate, size=1.2, noisy=False)]
    return [s for s in found if s is not None]


def along(model, samples):
    """Return the Motion of samples, its EffectInput and the torque (N, n) [Nm] of LOAD."""
    motion = Motion(*(np.array([getattr(s, name) for s in samples])
                      for name in Motion.__dataclass_fields__))
    x, _ = motion_input(model.robot, motion, model.presliding_distance())
    return motion, x, np.array([model.robot.load_regressor(*row) @ LOAD.to_products()
                                for row in zip(motion.q, motion.v, motion.a)])


@pytest.fixture(scope='module')
def samples():
    """Return MotionSamples of 5 s at 125 Hz."""
    return filtered(5.0, 125.0)


@pytest.mark.parametrize('name', BOUND)
def test_online_is_as_offline(name, samples):
    """The follower, sample by sample, gives what identification had for all rows at once."""
    model = model_with(four_axes(), (name,), {name: BOUND[name]},
                       {'shift': 0.05, 'travel': 0.02})
    motion, x, _ = along(model, samples)
    columns = torque_columns(model.robot, model.layout, x, model.mean, motion.dt)
    plain = model.layout.plain_torque(columns, model.mean)
    bound = columns @ model.mean - plain
    # An effect that does nothing here would agree in any case.
    assert (np.sqrt(np.mean(bound ** 2, axis=0)) > 0.005 * np.std(plain, axis=0)).sum() >= 3
    follower = ModelFollower(model)
    # What drives report differs from the model's own figure by the effect; here they agree.
    online = np.array([follower.update(replace(s, effort=tau)).difference
                       for s, tau in zip(samples, plain)])
    np.testing.assert_allclose(online, -bound, atol=1e-9)


def test_a_restart_forgets_the_torque_before(samples):
    """After a gap nothing of the torque before it comes late."""
    model = model_with(four_axes(), ('time_delay',), {'time_delay': (1.0,)}, {'shift': 0.05})
    plain = model_with(four_axes(), ('time_delay',), {'time_delay': (0.0,)}, {'shift': 0.05})
    followers = ModelFollower(model), ModelFollower(plain)
    for sample in samples[100:140]:
        late, now = (f.update(sample).difference for f in followers)
    assert np.abs(late - now).max() > 0.1
    for follower in followers:
        follower.restart()
    late, now = (f.update(samples[0]).difference for f in followers)
    np.testing.assert_allclose(late, now, atol=1e-12)


# Not base_tilt: what a leaning base does to a known load is left out of identification.
@pytest.mark.parametrize('name', ['torque_scale', 'torque_scale_temperature',
                                  'load_dependent_friction', 'time_delay'])
def test_a_load_goes_through_the_effects_as_a_known_one_does(name, samples):
    """K m online is what identification adds to the torque for a known load m."""
    model = model_with(four_axes(), (name,), {name: BOUND[name]})
    motion, x, held = along(model, samples)
    empty, full = (torque_columns(model.robot, model.layout, x, model.mean, motion.dt, h)
                   @ model.mean for h in (None, held))
    if name == 'load_dependent_friction':
        # The load must turn a gear's torque round somewhere: friction is bent there.
        gear = columns_of_links(model, x)
        assert 0.01 < (np.sign(gear) != np.sign(gear + held)).mean() < 0.7
    follower = ModelFollower(model)
    follower.carry(SimpleNamespace(mean=LOAD.to_message()), SimpleNamespace(tared=np.zeros(10)))
    seen = [follower.update(s) for s in samples]
    through = np.array([s.effort - p.difference + p.load_columns @ LOAD.to_products()
                        for s, p in zip(samples, seen)])
    np.testing.assert_allclose(through, full + held, atol=1e-9)
    assert np.abs(through - empty - held).max() > 0.02 * np.abs(held).max()


def columns_of_links(model, x):
    """Return the links' torque (N, n) [Nm]."""
    links = ColumnLayout(model.robot.n, ())
    return torque_columns(model.robot, links, x) @ model.mean[:links.size]


def test_teeth_part_where_the_torque_of_gear_and_load_changes_sign(samples):
    """A load that is believed to be held counts as a known one does in identification."""
    model = model_with(four_axes(), ('backlash',), {'backlash': BOUND['backlash']},
                       {'travel': 0.02})
    motion, x, held = along(model, samples)
    full = torque_columns(model.robot, model.layout, x, model.mean, motion.dt, held) @ model.mean
    belief = SimpleNamespace(mean=LOAD.to_message())
    followers = ModelFollower(model), ModelFollower(model)
    followers[1].carry(belief, SimpleNamespace(tared=np.zeros(10)))
    empty, known = (np.array([s.effort - f.update(s).difference for s in samples])
                    for f in followers)
    np.testing.assert_allclose(known, full, atol=1e-9)
    assert np.abs(empty - full).max() > 0.05


@pytest.mark.parametrize('rate', [30.0, 94.0, 500.0])
def test_a_follower_remembers_as_long_as_the_longest_delay(rate):
    """Samples are 10 to 33 ms apart, as messages come; the same time is remembered."""
    # A search goes on between the grid's values and beyond the last.
    longest = 1.4 * max(EFFECTS['time_delay'].shapes[0].grid)
    model = model_with(four_axes(), ('time_delay',), {'time_delay': (1.0,)}, {'shift': longest})
    found = filtered(3.0, rate)
    motion, x, _ = along(model, found)
    offline = torque_columns(model.robot, model.layout, x, model.mean, motion.dt) @ model.mean
    follower = ModelFollower(model)
    online = np.array([s.effort - follower.update(s).difference for s in found])
    np.testing.assert_allclose(online, offline, atol=1e-9)


def test_the_model_file_keeps_tilt_and_ripple(tmp_path):
    """An effect of the whole arm stands once, with all joints; a ripple keeps its period."""
    names = ('base_tilt', 'torque_ripple', 'backlash', 'time_delay')
    values = {'base_tilt': (0.01, -0.02), 'torque_ripple': (0.3, -0.2, 0.1, 0.05),
              'backlash': (0.1,), 'time_delay': (0.7,)}
    model = model_with(four_axes(), names, values, {'periods': 61.37, 'shift': 0.0171})
    entries = [e for e in model_content(model)['effects'] if e['name'] == 'base_tilt']
    assert [e['joints'] for e in entries] == [list(model.robot.joints)]
    write_model(tmp_path / 'model.yaml', model)
    back = read_model(tmp_path / 'model.yaml')
    assert back.uses == model.uses
    x = replace(inputs(), gear=None, drive=None, rate=None, tilt=None, late=None, play=None)
    one, two = (torque_columns(m.robot, m.layout, x, m.mean, np.full(60, DT)) @ m.mean
                for m in (model, back))
    np.testing.assert_allclose(two, one, rtol=1e-6, atol=1e-6)
    without = replace(model, mean=np.where(np.arange(len(model.mean)) < parameter_count(
        4, effect_uses(model.robot)), model.mean, 0.0))
    assert np.abs(torque_columns(model.robot, model.layout, x, without.mean, np.full(60, DT))
                  @ without.mean - one).max() > 0.5


def test_planning_knows_the_effects_too():
    """TorqueModel.torque: base tilt counts while the arm stands, a delay does not."""
    tilted = model_with(four_axes(), ('base_tilt', 'time_delay'),
                        {'base_tilt': (0.02, 0.0), 'time_delay': (1.0,)})
    plain = model_with(four_axes(), ('base_tilt', 'time_delay'),
                       {'base_tilt': (0.0, 0.0), 'time_delay': (0.0,)})
    q, zero = np.array([0.3, 0.5, -0.7, 0.9]), np.zeros(4)
    angles = np.array([0.02, 0.0])
    expected = tilted.robot.tilt_regressor(q, tilted.robot.nominal_links, angles) @ angles
    np.testing.assert_allclose(tilted.torque(q, zero, zero) - plain.torque(q, zero, zero),
                               expected, atol=1e-12)
    assert np.abs(expected).max() > 0.05


def test_doubt_about_friction_comes_late_with_the_torque(samples):
    """A delayed joint moves already when what it held at rest is reported; others as before."""
    model = model_with(four_axes(), ('torque_offset',), {'torque_offset': (0.0,)})
    delay = EffectUse('time_delay', 1, {'shift': 2.0 * samples[1].dt})
    late = replace(model, uses=(*model.uses, delay), mean=np.append(model.mean, 1.0),
                   covariance=np.pad(model.covariance, (0, 1)))
    stuck, held = (np.array([f.update(s).stuck for s in samples])
                   for f in (ModelFollower(model), ModelFollower(late)))
    assert np.ptp(stuck[:, 1]) > 0.0
    np.testing.assert_array_equal(held[:, [0, 2, 3]], stuck[:, [0, 2, 3]])
    np.testing.assert_allclose(held[2:, 1], stuck[:-2, 1], atol=1e-12)
    dt = np.array([s.dt for s in samples])
    np.testing.assert_allclose(as_reported(late.uses, stuck, dt), held, atol=1e-12)


def test_weights_of_a_late_torque_are_those_of_its_moment(samples):
    """Identification believes a delayed joint's rows as online estimation does."""
    model = model_with(four_axes(), ('time_delay',), {'time_delay': (1.0,)},
                       {'shift': 2.0 * samples[1].dt})
    motion, _, _ = along(model, samples)
    evidence = Evidence('run', motion, motion.effort)
    plain = tuple(use for use in model.uses if use.name != 'time_delay')
    late, now = (System(model.robot, uses, [evidence], model.mean[:parameter_count(4, uses)])
                 .weights(1.0, np.ones(4)) / motion.dt[:, None] for uses in (model.uses, plain))
    assert np.ptp(now) > 0.0
    np.testing.assert_allclose(1.0 / late[2:], 1.0 / now[:-2], rtol=1e-9)
