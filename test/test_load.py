"""Load parameters: conventions, Jacobians, frames, physicality; the regressor they multiply."""

from core_helpers import block, four_axes
import numpy as np
import pinocchio as pin
from plant_helpers import ur10e
import pytest
import yaml

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.configuration import read_yaml
from hand_load_estimator.files.load_file import load_of_argument, read_load_file, write_load_file
from hand_load_estimator.load import (LoadEstimate, LoadParameters, message_from_products,
                                      message_from_shape, message_jacobian_of_shape,
                                      products_from_message, products_from_shape,
                                      products_jacobian_of_message, products_jacobian_of_shape,
                                      products_transform, pseudo_inertia, together)

ROBOTS = {'ur10e': ur10e, 'four axes': four_axes}


def random_load(rng, lightest=0.3):
    """Return a load with an offset centre of mass and a full tensor."""
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    mass, moments = rng.uniform(lightest, 8.0), rng.uniform(0.01, 0.05, 3)
    inertia = axes @ np.diag(moments.sum() - moments) @ axes.T
    return LoadParameters(mass, rng.uniform(-0.2, 0.2, 3), inertia)


def pinocchio_inertia(load):
    return pin.Inertia(load.mass, np.array(load.com), np.array(load.inertia))


def with_load(robot, load):
    """Return the robot's pinocchio model with the load welded to its load frame."""
    model = robot.model.copy()
    frame = model.frames[model.getFrameId(robot.load_frame)]
    model.appendBodyToJoint(frame.parentJoint, pinocchio_inertia(load), frame.placement)
    return model


@pytest.mark.parametrize('name', ROBOTS)
def test_e4_1_regressor_times_load_is_what_rnea_adds(name):
    robot, rng = ROBOTS[name](), np.random.default_rng(1)
    for _ in range(10):
        load = random_load(rng)
        loaded = with_load(robot, load)
        q, v, a = rng.uniform(-2.0, 2.0, (3, robot.n))
        more = pin.rnea(loaded, loaded.createData(), q, v, a)
        less = pin.rnea(robot.model, robot.model.createData(), q, v, a)
        np.testing.assert_allclose(robot.load_regressor(q, v, a) @ load.to_products(),
                                   more - less, atol=1e-9)
        np.testing.assert_allclose(robot.rigid_torque(q, v, a, load), more, atol=1e-9)


def test_loads_together_are_what_pinocchio_adds():
    rng = np.random.default_rng(4)
    one, other = random_load(rng), random_load(rng)
    both, expected = together([one, other]), pinocchio_inertia(one) + pinocchio_inertia(other)
    assert both.mass == pytest.approx(expected.mass)
    np.testing.assert_allclose(both.com, expected.lever)
    np.testing.assert_allclose(both.inertia, expected.inertia)
    assert together([one]) is one


@pytest.mark.parametrize('name', ROBOTS)
def test_e1_1_link_regressor_times_nominal_is_rnea(name):
    robot, rng = ROBOTS[name](), np.random.default_rng(2)
    for _ in range(5):
        q, v, a = rng.uniform(-2.0, 2.0, (3, robot.n))
        np.testing.assert_allclose(
            robot.link_regressor(q, v, a) @ robot.nominal_links,
            pin.rnea(robot.model, robot.model.createData(), q, v, a), atol=1e-9)


def test_gravity_of_the_robot_file_is_used():
    upright, hanging = ur10e(), ROBOTS['four axes'](gravity=[0.0, 0.0, 9.81])
    standing = four_axes()
    q, zero = np.full(4, 0.4), np.zeros(4)
    np.testing.assert_allclose(hanging.rigid_torque(q, zero, zero),
                               -standing.rigid_torque(q, zero, zero), atol=1e-12)
    assert np.abs(upright.rigid_torque(np.zeros(6), np.zeros(6), np.zeros(6))).max() > 10.0


def test_mass_matrix_is_what_acceleration_costs():
    robot, rng = four_axes(), np.random.default_rng(3)
    q, a, zero = rng.normal(size=4), rng.normal(size=4), np.zeros(4)
    np.testing.assert_allclose(robot.mass_matrix(q) @ a, robot.rigid_torque(q, zero, a)
                               - robot.rigid_torque(q, zero, zero), atol=1e-10)


def test_products_are_pinocchios():
    rng = np.random.default_rng(4)
    for _ in range(5):
        load = random_load(rng)
        np.testing.assert_allclose(load.to_products(),
                                   pinocchio_inertia(load).toDynamicParameters(), atol=1e-12)


def test_message_round_trips():
    rng = np.random.default_rng(7)
    loads = [random_load(rng) for _ in range(20)]
    vectors = np.array([load.to_message() for load in loads])
    np.testing.assert_allclose(message_from_products(products_from_message(vectors)), vectors,
                               atol=1e-12)
    for load, vector in zip(loads, vectors):
        back = LoadParameters.from_message(vector)
        np.testing.assert_allclose(back.inertia, load.inertia, atol=1e-15)
        np.testing.assert_array_equal(back.com, load.com)


def test_shape_is_inertia_per_mass():
    load = random_load(np.random.default_rng(8))
    shape = load.to_message().copy()
    shape[4:] /= load.mass
    np.testing.assert_allclose(message_from_shape(shape), load.to_message(), atol=1e-15)
    np.testing.assert_allclose(products_from_shape(shape), load.to_products(), atol=1e-15)


def test_no_mass_has_no_place_and_no_infinity():
    products = np.zeros(10)
    products[4] = 0.01
    vector = message_from_products(products)
    assert np.isfinite(vector).all() and (vector[:4] == 0.0).all() and vector[4] == 0.01


@pytest.mark.parametrize('function, jacobian', [
    (products_from_shape, products_jacobian_of_shape),
    (products_from_message, products_jacobian_of_message),
    (message_from_shape, message_jacobian_of_shape)])
def test_jacobians_are_the_slopes(function, jacobian):
    rng, step = np.random.default_rng(9), 1e-6
    at = np.concatenate([rng.uniform(0.5, 5.0, (3, 1)), rng.normal(0.0, 0.2, (3, 9))], axis=1)
    slopes = np.stack([(function(at + step * e) - function(at - step * e)) / (2.0 * step)
                       for e in np.eye(10)], axis=-1)
    np.testing.assert_allclose(jacobian(at), slopes, atol=1e-7)
    np.testing.assert_array_equal(jacobian(at[1]), jacobian(at)[1])


def test_products_move_between_frames_as_pinocchio_moves_inertias():
    rng = np.random.default_rng(10)
    for _ in range(5):
        load, pose = random_load(rng), pin.SE3.Random()
        np.testing.assert_allclose(
            products_transform(pose.rotation, pose.translation) @ load.to_products(),
            pose.act(pinocchio_inertia(load)).toDynamicParameters(), atol=1e-11)


def test_pseudo_inertia_tells_bodies_from_numbers():
    load = block(3.0)
    assert load.is_physical()
    assert np.linalg.eigvalsh(pseudo_inertia(load.to_products()))[0] > 0.0
    # One principal moment larger than the sum of the others: no body has that.
    impossible = LoadParameters(3.0, load.com, np.diag([0.01, 0.01, 0.03]))
    assert not impossible.is_physical()
    assert np.linalg.eigvalsh(pseudo_inertia(impossible.to_products()))[0] < 0.0


@pytest.mark.parametrize('load, physical', [
    (LoadParameters(), True),
    (LoadParameters(0.0, np.zeros(3), 0.01 * np.eye(3)), False),
    (LoadParameters(-1.0), False),
    (LoadParameters(1.0, [np.nan, 0.0, 0.0]), False),
    (LoadParameters(1.0, np.zeros(3), np.full((3, 3), 1e308)), False),
    (LoadParameters(2.0, np.zeros(3), np.diag([0.01, 0.01, 0.02])), True)])
def test_edges_of_physicality(load, physical):
    assert load.is_physical() is physical


def test_loads_and_estimates_cannot_be_changed():
    load = block(1.0)
    with pytest.raises(ValueError):
        load.com[0] = 1.0
    estimate = LoadEstimate(0.0, load.to_message(), np.eye(10), np.zeros(10), 'ESTIMATING')
    for array in (estimate.mean, estimate.covariance, estimate.determined):
        with pytest.raises(ValueError):
            array[0] = 1.0
    np.testing.assert_allclose(estimate.load.inertia, load.inertia)


def test_wrong_shapes_and_statuses_are_refused():
    with pytest.raises(ValueError, match='com has shape'):
        LoadParameters(1.0, [0.0, 0.0])
    with pytest.raises(ValueError, match='GUESSING'):
        LoadEstimate(0.0, np.zeros(10), np.eye(10), np.zeros(10), 'GUESSING')


def test_load_file_round_trip(tmp_path):
    write_load_file(tmp_path / 'load.yaml', block(2.5))
    load, known = read_load_file(tmp_path / 'load.yaml')
    np.testing.assert_array_equal(load.to_message(), block(2.5).to_message())
    assert known == ('mass', 'com', 'inertia')


def test_what_a_load_file_does_not_say_is_not_known(tmp_path):
    (tmp_path / 'load.yaml').write_text('mass: 2.6\n')
    load, known = read_load_file(tmp_path / 'load.yaml')
    assert load.mass == 2.6 and known == ('mass',)
    (tmp_path / 'load.yaml').write_text('none\n')
    load, known = read_load_file(tmp_path / 'load.yaml')
    assert load.mass == 0.0 and known == ('mass', 'com', 'inertia')


def test_a_load_file_may_say_that_its_load_is_assumed(tmp_path):
    (tmp_path / 'load.yaml').write_text('mass: 150.0\ncom: [0, 0, 0.1]\nassumed: true\n')
    load, known = read_load_file(tmp_path / 'load.yaml')
    assert load.mass == 150.0 and known == ('mass', 'com', 'assumed')
    (tmp_path / 'load.yaml').write_text('mass: 2.6\nassumed: false\n')
    assert read_load_file(tmp_path / 'load.yaml')[1] == ('mass',)


@pytest.mark.parametrize('text, key', [
    ('mass: 1.0\nassumed: perhaps\n', 'assumed'),
    ('mass: -1.0\n', 'mass'), ('mass: heavy\n', 'mass'), ('com: [0, 0, 0]\n', 'mass'),
    (f'mass: 1{400 * "0"}\n', 'mass'), (f'mass: 1.0\ncom: [0, 0, 1{400 * "0"}]\n', 'com'),
    ('mass: 1.0\ncom: [0, 0]\n', 'com'), ('mass: 1.0\ninertia: [1, 0, 0]\n', 'inertia'),
    ('mass: 1.0\ninertia: [0.01, 0, 0, 0.01, 0, 0.05]\n', 'inertia'),
    ('mass: .nan\n', 'mass'), ('mass: 1.0\ncolour: red\n', 'colour'), ('[1, 2]\n', 'mapping'),
    ('mass: [\n', 'YAML')])
def test_wrong_load_files_are_refused_with_place_and_key(tmp_path, text, key):
    path = tmp_path / 'load.yaml'
    path.write_text(text)
    with pytest.raises(ConfigurationError) as caught:
        read_load_file(path)
    assert str(path) in str(caught.value) and key in str(caught.value)


@pytest.mark.parametrize('loader', ['CSafeLoader', 'SafeLoader'])
def test_a_key_that_is_there_twice_is_refused(tmp_path, monkeypatch, loader):
    """The last held: a load of 2.5 kg was one of 0.25 kg."""
    monkeypatch.setattr(yaml, 'CSafeLoader', getattr(yaml, loader))
    path = tmp_path / 'load.yaml'
    for text, key, lines in (('mass: 2.5\ncom: [0, 0, 0.1]\nmass: 0.25\n', 'mass', '1 and 3'),
                             ('a: [{b: 1, b: 2}]\n', 'b', '1 and 1')):
        path.write_text(text)
        with pytest.raises(ConfigurationError, match=f'{path}: {key}: .*lines {lines}'):
            read_yaml(path)


@pytest.mark.parametrize('loader', ['CSafeLoader', 'SafeLoader'])
def test_a_key_that_is_merged_may_be_told_anew(tmp_path, monkeypatch, loader):
    monkeypatch.setattr(yaml, 'CSafeLoader', getattr(yaml, loader))
    path = tmp_path / 'load.yaml'
    path.write_text('a: &a {m: 1, n: 2}\nb: {in: &b {<<: *a, m: 3}}\nc: {<<: [*b], n: 4}\n'
                    'd: &d [*a, *d]\n')
    content = read_yaml(path)
    assert content['b']['in'] == {'m': 3, 'n': 2} and content['c'] == {'m': 3, 'n': 4}


def test_load_argument_is_none_or_a_file(tmp_path):
    assert load_of_argument('none')[0].mass == 0.0
    with pytest.raises(ConfigurationError, match='--load.*nowhere'):
        load_of_argument(str(tmp_path / 'nowhere.yaml'))
