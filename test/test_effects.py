"""Effects: columns of the stated shape and physics."""

from dataclasses import replace
from pathlib import Path

from core_helpers import four_axes
from effect_helpers import DT, inputs, model_with, shown_of
import numpy as np
import pytest

from hand_load_estimator import effects
from hand_load_estimator.effects import DESCRIBED, EFFECTS, EffectInput
from hand_load_estimator.torque.columns import (ColumnLayout, effect_slices, EffectUse,
                                                parameter_count, torque_columns)
from hand_load_estimator.torque.lateness import lateness
from hand_load_estimator.torque.play import PlayAlong

ALWAYS = ('q', 'v', 'a', 'warmth', 'z', 'at_once', 'shown')


def shapes_of(effect, count):
    """Return a different value of each shape parameter for so many joints."""
    return {s.name: np.array([s.grid[k % len(s.grid)] if s.grid else 40.0 + 7.0 * k
                              for k in range(count)])
            for s in effect.shapes}


def of_joint(effect, x, j, value=None):
    shape = {s.name: s.default if value is None else value for s in effect.shapes}
    return effect.columns(x, j, shape)


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
        if field not in ('late', 'play', 'shown', 'jerk', 'tilt'):
            mixed[field] = getattr(other, field).copy()
            mixed[field][:, 2] = getattr(x, field)[:, 2]
    dt = np.full(60, DT)
    tilt = np.where(np.arange(4)[:, None] == 2, x.tilt(), other.tilt())
    mixed = EffectInput(**mixed, shown=shown_of(*(mixed[k] for k in ('q', 'v', 'a', 'warmth'))),
                        tilt=lambda: tilt, late=lateness(mixed['drive'], dt),
                        play=PlayAlong(((mixed['drive'], 2.0 + np.zeros((60, 4)), dt),),
                                       np.full(4, 2.0)))
    np.testing.assert_allclose(of_joint(effect, mixed, 2), of_joint(effect, x, 2))
    assert of_joint(effect, x, 1).shape == of_joint(effect, x, 2).shape


def test_joints_may_be_declared_in_any_order():
    x, n = inputs(), 4
    uses = [EffectUse(name, joint, EFFECTS[name].default_shape())
            for name in ('viscous_friction', 'stribeck_friction') for joint in (2, 0, 3, 1)]
    columns = np.zeros((60, n, parameter_count(n, uses)))
    ColumnLayout(n, uses).fill(columns, x)
    for use, where in effect_slices(n, uses):
        np.testing.assert_allclose(columns[:, use.joint, where],
                                   use.effect.columns(x, use.joint, use.shape), rtol=1e-12,
                                   atol=1e-15)
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
        sliding = replace(x, z=np.sign(x.v), gear=np.full_like(x.v, gear),
                          gear_way=np.zeros_like(x.v))
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


def test_every_name_of_the_design_has_a_file_that_says_what_it_is():
    names = set(EFFECTS) | set(DESCRIBED)
    assert {'link_inertia', 'external_contact', 'load_change', 'gravity_spring'} <= names
    assert not set(EFFECTS) & set(DESCRIBED)
    folder = Path(effects.__file__).parent
    for entry in (*EFFECTS.values(), *DESCRIBED.values()):
        assert (folder / f'{entry.name}.py').is_file() or entry.name.startswith('learned')
        assert len(entry.physics) > 15 and entry.parameters
        # A paper, a reference's equation, or what it follows from.
        assert any(c.isdigit() for c in entry.source) or 'first principles: ' in entry.source \
            or entry.name.startswith('learned')
        assert all(isinstance(name, str) and isinstance(unit, str)
                   for name, unit in entry.parameters)
