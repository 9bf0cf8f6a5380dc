"""Limits and thresholds know what the model's effects make of a load, as the estimator does."""

from dataclasses import replace

from control_helpers import belief, FAR_PLACE, HOME, load_vector, WARM
import numpy as np
import pytest

from hand_load_estimator.control.collision_threshold import CollisionThresholds
from hand_load_estimator.control.torque_use import TorqueUse
from hand_load_estimator.effects import EffectInput
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import LoadParameters, products_from_message
from hand_load_estimator.torque.columns import EffectUse, torque_columns, warmth_of
from hand_load_estimator.torque.model_file import read_model

MASS = 6.0
PRODUCTS = products_from_message(load_vector(MASS))
SLOW = FAR_PLACE, np.array([0.0, 0.15, -0.15, 0.15, 0.0, 0.0]), np.zeros(6)
QUICK = FAR_PLACE, np.array([0.8, -0.6, 0.7, 0.5, 0.4, -0.6]), np.full(6, 2.0)


def model_with(**effects):
    """Return the shipped model with effects of stated values on joint 1, or on the arm."""
    model = read_model(find_shared('ur10e', 'models'))
    uses = tuple(EffectUse(name, 0 if name == 'base_tilt' else 1) for name in effects)
    values = np.concatenate([np.atleast_1d(value) for value in effects.values()])
    size = len(model.mean) + len(values)
    covariance = np.zeros((size, size))
    covariance[:len(model.mean), :len(model.mean)] = model.covariance
    return replace(model, uses=model.uses + uses, mean=np.append(model.mean, values),
                   covariance=covariance)


def torque_of_load(model, q, v, a):
    """Return what the load adds to the torque (n,), as identification has a known one."""
    load = LoadParameters(MASS, [0.0, 0.0, 0.1], 0.01 * MASS * np.eye(3))
    rows = [row[None] for row in (q, v, a, warmth_of(model.robot, WARM))]
    x = EffectInput(*rows, np.sign(rows[1]))
    empty, full = (torque_columns(model.robot, model.layout, x, model.mean, load=given)[0]
                   @ model.mean for given in (None, load))
    return full - empty + model.robot.load_regressor(q, v, a) @ PRODUCTS


EFFECTS = [{'load_dependent_friction': 0.08}, {'torque_scale': 0.08},
           {'torque_scale': -0.05, 'load_dependent_friction': 0.09}]


@pytest.mark.parametrize('state', [SLOW, QUICK])
@pytest.mark.parametrize('effects', EFFECTS)
def test_a_load_adds_what_it_does_in_identification(effects, state):
    model = model_with(**effects)
    regressor, beside = model.load_while_sliding(*state, WARM, PRODUCTS)
    wanted = torque_of_load(model, *state)
    np.testing.assert_allclose(regressor @ PRODUCTS + beside, wanted, atol=1e-9)
    plain = model.robot.load_regressor(*state) @ PRODUCTS
    assert abs(wanted - plain)[1] > 1.0


def test_a_leaning_base_turns_the_weight_of_a_load():
    model = model_with(base_tilt=(0.02, -0.03))
    regressor, beside = model.load_while_sliding(*SLOW, WARM, PRODUCTS)
    leaning = model.robot.tilted_load_columns(FAR_PLACE, np.array([0.02, -0.03]))
    np.testing.assert_allclose(
        regressor, model.robot.load_regressor(*SLOW)
        + np.einsum('a,ajk->jk', [0.02, -0.03], leaning))
    assert not beside.any()


@pytest.mark.parametrize('effects', EFFECTS)
def test_a_load_behind_such_a_gear_is_no_collision(effects):
    """Where only the rigid body counts, it is 3 to 6 Nm beyond a threshold of a few Nm."""
    model = model_with(**effects)
    found, _ = CollisionThresholds(model).at(*SLOW, belief(MASS, 0.005, com_std=0.0005), WARM)
    off = np.abs(torque_of_load(model, *SLOW) - found.expected)
    assert (off < 0.5 * found.threshold).all()
    rigid = model.robot.load_regressor(*SLOW) @ PRODUCTS
    assert np.abs(rigid - torque_of_load(model, *SLOW))[1] > found.threshold[1]


def test_at_rest_the_teeth_may_hold_it_either_way():
    still, known = np.zeros(6), belief(MASS, 0.005, com_std=0.0005)
    plain, teeth = (CollisionThresholds(model_with(**effects)).at(HOME, still, still, known, WARM)
                    [0].threshold for effects in ({'torque_scale': 0.0}, EFFECTS[0]))
    weight = model_with(torque_scale=0.0).robot.load_regressor(HOME, still, still) @ PRODUCTS
    assert teeth[1] - plain[1] > 0.08 * abs(weight[1])


def test_limits_count_the_gain():
    plain, scaled = (TorqueUse(model_with(torque_scale=value), belief(MASS), 3.0, WARM)
                     for value in (0.0, 0.4))
    assert scaled.at(*SLOW) > 1.05 * plain.at(*SLOW)
