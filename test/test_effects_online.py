"""Effects that depend on torques: the follower, sample by sample, is as identification."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import exact_model, four_axes, messages
from effect_helpers import model_with
import numpy as np
import pytest

from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.estimators.rest_watch import (ANOTHER_LOAD, MARGIN, NOTHING,
                                                        RestWatch)
from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.identification.regression_system import System
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.motion import Motion, MotionFilter
from hand_load_estimator.torque.columns import (ColumnLayout, EffectUse, parameter_count,
                                                torque_columns)
from hand_load_estimator.torque.lateness import as_reported
from hand_load_estimator.torque.misread_weight import misread_directions
from hand_load_estimator.torque.model_follower import ModelFollower
from hand_load_estimator.torque.motion_inputs import motion_input
from hand_load_estimator.torque.shown_links import shown_links
from hand_load_estimator.torque_model import _write_delays, drift_std, uncertain_directions

LOAD = LoadParameters(2.0, [0.02, -0.03, 0.1], 0.01 * np.eye(3))
# Values of the effects that depend on torques, large enough to be seen in one.
BOUND = {'base_tilt': (0.02, -0.03), 'load_dependent_friction': (0.05,),
         'backlash': (0.8,), 'torque_scale': (0.04,),
         'torque_scale_temperature': (2e-3,), 'time_delay': (0.8,)}
# What pulls on the links, through the gears.
PULLS = {'gravity_spring': (-4.0, 1.0), 'cable_drag': (0.5, 0.2, -0.3, 0.1, 0.05)}
VALUES = BOUND | PULLS


def filtered(seconds, rate):
    """Return MotionSamples of a motion at a rate [Hz] through the filter, warm joints."""
    motion = MotionFilter(4)
    for joint in range(4):
        motion.temperature[joint] = 37.0
    found = [motion.update(m.stamp, m.position, m.velocity, m.effort) for m in messages(
        exact_model('four'), LoadParameters(), seconds, rate=rate, size=1.2, noisy=False)]
    return [s for s in found if s is not None]


def along(model, samples):
    """Return the Motion of samples, its EffectInput and the torque (N, n) [Nm] of LOAD."""
    motion = Motion(*(np.array([getattr(s, name) for s in samples])
                      for name in Motion.__dataclass_fields__))
    x, _ = motion_input(model.robot, motion, model.presliding_distance(),
                        level=model.contact_level())
    held = model.robot.load_columns(shown_links(model.robot, motion)) @ LOAD.to_products()
    return motion, x, held


@pytest.fixture(scope='module')
def samples():
    """Return MotionSamples of 5 s at 125 Hz."""
    return filtered(5.0, 125.0)


@pytest.mark.parametrize('names', [(name,) for name in BOUND] + [
    tuple(BOUND), tuple(VALUES), (*PULLS, 'load_dependent_friction')])
def test_online_is_as_offline(names, samples):
    """The follower, sample by sample, gives what identification had for all rows at once."""
    model = model_with(four_axes(), names, {name: VALUES[name] for name in names},
                       {'shift': 0.05, 'travel': 0.02})
    motion, x, _ = along(model, samples)
    columns = torque_columns(model.robot, model.layout, x, model.mean, motion.dt)
    without = np.concatenate([np.arange(where.start, where.stop)
                              for use, where in model.slices() if use.name in BOUND])
    plain = np.delete(columns, without, axis=2) @ np.delete(model.mean, without)
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


@pytest.mark.parametrize('names', [
    ('torque_scale',), ('torque_scale_temperature',), ('load_dependent_friction',),
    ('base_tilt',), ('time_delay',),
    ('time_delay', 'torque_scale'), ('time_delay', 'load_dependent_friction'),
    ('torque_scale', 'torque_scale_temperature', 'load_dependent_friction', 'base_tilt'),
    (*PULLS, 'load_dependent_friction')])
def test_a_load_goes_through_the_effects_as_a_known_one_does(names, samples):
    """K m online is what identification adds to the torque for a known load m."""
    model = model_with(four_axes(), names, {name: VALUES[name] for name in names})
    motion, x, held = along(model, samples)
    empty, full = (torque_columns(model.robot, model.layout, x, model.mean, motion.dt, load)
                   @ model.mean for load in (None, LOAD))
    if 'load_dependent_friction' in names:
        # The load must turn a gear's torque round somewhere: friction is bent there.
        gear = columns_of_links(model, x) + model.link_pull(x)[0]
        assert 0.01 < (np.sign(gear) != np.sign(gear + held)).mean() < 0.7
    follower = ModelFollower(model)
    follower.carry(SimpleNamespace(mean=LOAD.to_message()), SimpleNamespace(tared=np.zeros(10)))
    seen = [follower.update(s) for s in samples]
    through = np.array([s.effort - p.difference + p.load_columns @ LOAD.to_products()
                        for s, p in zip(samples, seen)])
    np.testing.assert_allclose(through, full + held, atol=1e-9)
    assert np.abs(through - empty - held).max() > 0.02 * np.abs(held).max()


@pytest.mark.parametrize('name', ['torque_scale', 'torque_scale_temperature',
                                  'load_dependent_friction', 'base_tilt'])
def test_what_a_gain_may_be_off_by_grows_with_the_load(name, samples):
    """Its doubt is about the torque of arm and load, not of the arm alone."""
    model = model_with(four_axes(), (name,), {name: BOUND[name]})
    where = next(own for use, own in model.slices() if use.name == name
                 and use.joint in (0, 1) and (use.joint or name == 'base_tilt'))
    doubt = np.zeros_like(model.covariance)
    doubt[where.start, where.start] = 0.01 ** 2
    doubtful = replace(model, covariance=doubt)
    motion, x, _ = along(model, samples)
    full = torque_columns(model.robot, model.layout, x, model.mean, motion.dt, LOAD)
    follower = ModelFollower(doubtful)
    follower.carry(SimpleNamespace(mean=LOAD.to_message()), SimpleNamespace(tared=np.zeros(10)))
    parameters = slice(misread_directions(model.robot.n), -3 * model.robot.n)
    seen = np.array([np.linalg.norm(follower.update(s).model_columns[1, parameters])
                     for s in samples])
    np.testing.assert_allclose(seen, 0.01 * np.abs(full[:, 1, where.start]), atol=1e-9)


def columns_of_links(model, x):
    """Return the links' torque (N, n) [Nm]."""
    links = ColumnLayout(model.robot.n, ())
    return torque_columns(model.robot, links, x) @ model.mean[:links.size]


def test_teeth_part_where_the_torque_of_gear_and_load_changes_sign(samples):
    """A load that is believed to be held counts as a known one does in identification."""
    model = model_with(four_axes(), ('backlash',), {'backlash': BOUND['backlash']},
                       {'travel': 0.02})
    motion, x, _ = along(model, samples)
    full = torque_columns(model.robot, model.layout, x, model.mean, motion.dt, LOAD) @ model.mean
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
    # A search goes on between the grid's values and beyond the last, again for one declared.
    longest = 5.0 * max(EFFECTS['time_delay'].shapes[0].grid)
    model = model_with(four_axes(), ('time_delay',), {'time_delay': (1.0,)}, {'shift': longest})
    found = filtered(3.0, rate)
    motion, x, _ = along(model, found)
    offline = torque_columns(model.robot, model.layout, x, model.mean, motion.dt) @ model.mean
    follower = ModelFollower(model)
    online = np.array([s.effort - follower.update(s).difference for s in found])
    np.testing.assert_allclose(online, offline, atol=1e-9)


def drifting(model):
    """Return a model with a drift of offset, Coulomb and viscous friction."""
    return replace(model, residuals=replace(model.residuals, drift=np.full((4, 3), 0.1)))


def test_what_is_read_wrong_or_bends_is_read_late(samples):
    """With a whole delay everything else of a joint comes late, its uncertainty with it."""
    steps, bound = 4, [name for name in BOUND if name != 'time_delay']
    model = drifting(model_with(four_axes(), bound, {name: BOUND[name] for name in bound},
                                {'travel': 0.02}))
    delays = tuple(EffectUse('time_delay', j, {'shift': steps * samples[1].dt})
                   for j in range(4))
    late = replace(model, uses=(*model.uses, *delays), mean=np.append(model.mean, np.ones(4)),
                   covariance=np.pad(model.covariance, (0, 4)))
    now, then = ([f.update(replace(s, effort=np.zeros(4))) for s in samples]
                 for f in (ModelFollower(model), ModelFollower(late)))
    torque = np.array([p.difference for p in now])
    np.testing.assert_allclose([p.difference for p in then[steps:]], torque[:-steps], atol=1e-9)
    ahead = misread_directions(4)
    for name, columns in (('load_columns', slice(0, 10)), ('model_columns', slice(0, ahead)),
                          ('model_columns', slice(ahead, ahead + 12)),
                          ('model_columns', slice(ahead + 12, None))):
        before, after = (np.array([getattr(p, name)[:, columns] for p in those])
                         for those in (now, then))
        assert np.ptp(before, axis=0).max() > 1e-3
        np.testing.assert_allclose(after[steps:], before[:-steps], atol=1e-9)


def test_uncertainties_online_are_those_of_identification(samples):
    """That of a delay's share, which is late already, among them."""
    names = ('torque_scale', 'time_delay')
    model = drifting(model_with(four_axes(), names, {name: BOUND[name] for name in names},
                                {'shift': 0.05}))
    motion, _, _ = along(model, samples)
    system = System(model.robot, model.uses, [Evidence('run', motion, motion.effort)], model.mean)
    follower = ModelFollower(model)
    uncertain = uncertain_directions(model, 12, 0)
    assert np.abs(uncertain[model.layout.late]).max() > 1e-3
    seen = np.array([follower.update(s).model_columns for s in samples])
    seen = seen[:, :, misread_directions(4):]
    np.testing.assert_allclose(seen[:, :, :12], system.columns @ uncertain, atol=1e-9)
    drift = drift_std(model, np.ones(4, bool))
    offset, coulomb, viscous = (seen[:, 1, 12 + 4 * k + 1] for k in range(3))
    for column, basis, std in zip((offset, coulomb, viscous),
                                  (np.ones(len(seen)), *(w[:, 1] for w in system.drifting)),
                                  drift[1]):
        np.testing.assert_allclose(column, basis * std, atol=1e-9)


def test_what_a_delay_does_to_a_single_state_is_what_it_does_along_a_motion(samples):
    model = model_with(four_axes(), ('time_delay',), {'time_delay': (0.8,)}, {'shift': 0.02})
    _, x, _ = along(model, samples)
    motion = Motion(*(np.array([getattr(s, name) for s in samples])
                      for name in Motion.__dataclass_fields__))
    late = (..., model.layout.late)
    along_it = torque_columns(model.robot, model.layout, x, model.mean, motion.dt)
    alone = torque_columns(model.robot, model.layout, x, model.mean)
    assert not alone[late].any()
    _write_delays(model, x, alone)
    # Friction that turns within the shift is left out, and so is what the acceleration changes by.
    steady = (np.abs(x.z) > 0.999).all(axis=1) & (motion.stamp > motion.stamp[0] + 1.0)
    alone, along_it = alone[steady][late].ravel(), along_it[steady][late].ravel()
    assert steady.sum() > 100 and np.corrcoef(alone, along_it)[0, 1] > 0.9
    assert alone @ along_it / (alone @ alone) == pytest.approx(1.0, abs=0.2)


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
    np.testing.assert_allclose(as_reported(late.uses, stuck, dt, np.zeros(len(dt))), held,
                               atol=1e-12)


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


def test_a_joint_holds_the_more_the_more_its_gear_is_loaded(samples):
    """A torque that teeth can hold at rest is no changed load; beyond it is one."""
    model = model_with(four_axes(), ('load_dependent_friction',),
                       {'load_dependent_friction': BOUND['load_dependent_friction']})
    share = BOUND['load_dependent_friction'][0]
    follower = ModelFollower(model)
    follower.carry(SimpleNamespace(mean=LOAD.to_message()), SimpleNamespace(tared=np.zeros(10)))
    motion, x, held = along(model, samples[:50])
    friction = np.array([follower.update(s).friction for s in samples[:50]])
    gear = columns_of_links(model, x) + held
    np.testing.assert_allclose(friction, model.held_friction() + share * np.abs(gear), atol=1e-9)
    still = replace(samples[0], v=np.zeros(4), a=np.zeros(4), dt=0.02)
    # A load that shows in the second joint only.
    columns = np.zeros((4, 10))
    columns[1, 0] = 5.0
    beyond = []
    for factor in (0.9, 1.1):
        watch = RestWatch(model.robot.joints, np.zeros(4), np.eye(10))
        torque = np.array([0.0, factor * MARGIN * friction[-1, 1], 0.0, 0.0])
        prediction = SimpleNamespace(friction=friction[-1], load_columns=columns)
        beyond.append(max(watch.update(still, torque, np.zeros(4), prediction)
                          for _ in range(20)))
    assert beyond == [NOTHING, ANOTHER_LOAD]
