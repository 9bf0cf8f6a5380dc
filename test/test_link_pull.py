"""Gears carry what pulls on the links: a balancer takes weight off, a leaning base turns it."""

from dataclasses import replace
from functools import lru_cache

from core_helpers import four_axes
from effect_helpers import model_with
import numpy as np
import pytest
from residual_helpers import clean_runs, declared_model, diagnosed, SECONDS, told

from hand_load_estimator.effects import EffectInput
from hand_load_estimator.torque.columns import EffectUse, torque_columns

JOINT, COEFFICIENT = 1, 0.2
SPRING = {'gravity_spring': (-4.0, 1.0)}


def states(robot, count=40):
    """Return EffectInput of states while every joint slides."""
    rng = np.random.default_rng(3)
    q, v, a = rng.uniform(-1.0, 1.0, (3, count, robot.n))
    return EffectInput(q, v, a, np.zeros_like(q), np.sign(v))


def friction_of_teeth(model, x):
    """Return the torque (N, n) that the model's gear friction adds."""
    where = [own.start for use, own in model.slices() if use.name == 'load_dependent_friction']
    columns = torque_columns(model.robot, model.layout, x, model.mean)
    return columns[:, :, where] @ model.mean[where]


def test_a_balancer_that_carries_all_of_the_weight_leaves_its_gear_next_to_no_friction():
    robot = four_axes()
    model = model_with(robot, ('gravity_spring', 'load_dependent_friction'),
                       SPRING | {'load_dependent_friction': (0.1,)})
    x = states(robot)
    spring = np.sin(x.q) * SPRING['gravity_spring'][0] + np.cos(x.q) * SPRING['gravity_spring'][1]
    links = np.array([robot.link_regressor(*row) for row in zip(x.q, x.v, x.a)])
    gear = links @ model.mean[:10 * robot.n] + spring
    np.testing.assert_allclose(friction_of_teeth(model, x), 0.1 * np.abs(gear) * np.sign(x.v),
                               atol=1e-9)


def test_gears_of_a_leaning_arm_carry_its_weight_as_it_leans():
    robot, lean = four_axes(), (0.1, -0.05)
    model = model_with(robot, ('base_tilt', 'load_dependent_friction'),
                       {'base_tilt': lean, 'load_dependent_friction': (0.1,)})
    x, links = states(robot), model.mean[:10 * robot.n]
    gear = np.array([robot.link_regressor(*row) @ links
                     + robot.tilt_regressor(row[0], links, lean) @ lean
                     for row in zip(x.q, x.v, x.a)])
    np.testing.assert_allclose(friction_of_teeth(model, x), 0.1 * np.abs(gear) * np.sign(x.v),
                               atol=1e-9)


def test_a_gain_misreads_the_friction_of_teeth_and_the_lean_as_well():
    robot = four_axes()
    values = {'base_tilt': (0.1, -0.05), 'load_dependent_friction': (0.1,),
              'torque_scale': (0.05,)}
    model = model_with(robot, tuple(values), values)
    x = states(robot)
    columns = torque_columns(robot, model.layout, x, model.mean)
    gains = [own.start for use, own in model.slices() if use.name == 'torque_scale']
    given = columns @ model.mean - columns[:, :, gains] @ model.mean[gains]
    np.testing.assert_allclose(columns @ model.mean, 1.05 * given, atol=1e-9)


@lru_cache(None)
def balanced():
    """Return the spring (2,) that carries as much of the weight at JOINT as one can, a model."""
    robot, base = four_axes(), declared_model()
    weight = np.concatenate([[robot.rigid_torque(q, 0.0 * q, 0.0 * q)[JOINT] for q in x.q]
                             for x, _, _ in clean_runs(SECONDS)])
    angle = np.concatenate([x.q[:, JOINT] for x, _, _ in clean_runs(SECONDS)])
    spring = np.linalg.lstsq(np.column_stack([np.sin(angle), np.cos(angle)]), -weight,
                             rcond=None)[0]
    doubt = np.diag(np.append(np.zeros(len(base.mean)), (0.01 * spring) ** 2))
    doubt[:len(base.mean), :len(base.mean)] = base.covariance
    return spring, replace(base, uses=(*base.uses, EffectUse('gravity_spring', JOINT)),
                           mean=np.append(base.mean, spring), covariance=doubt)


def pulled(run):
    out = np.zeros_like(run.torque)
    angle = run.x.q[:, JOINT]
    out[:, JOINT] = np.column_stack([np.sin(angle), np.cos(angle)]) @ balanced()[0]
    return out


def toothed(run):
    """Friction that grows with the torque of a gear that a balancer takes weight off."""
    gear = np.array([run.robot.rigid_torque(*row) for row in zip(run.x.q, run.x.v, run.x.a)])
    gear = gear + pulled(run)
    return COEFFICIENT * np.abs(gear) * run.x.z * (np.arange(run.robot.n) == JOINT)


def test_friction_of_a_balanced_gear_is_found_with_its_coefficient():
    diagnosis, _ = diagnosed(pulled, toothed, model=balanced()[1])
    assert told(diagnosis) == {'load_dependent_friction': (f'j{JOINT}',)}
    (found,) = diagnosis.findings
    mean, std, _ = found.parameters['coefficient']
    assert mean == pytest.approx(COEFFICIENT, abs=3.0 * std) and std < 0.1 * COEFFICIENT
