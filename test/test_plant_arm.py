"""The MuJoCo arm obeys the same mechanics as pinocchio with the true parameters."""

from hand_load_estimator.load import LoadParameters
from hand_load_estimator.plant.arm import Arm
from hand_load_estimator.plant.difficulty import DEFAULT
from hand_load_estimator.plant.truth import draw_truth
import numpy as np
from plant_helpers import chain, LOAD, ur10e
import pytest


def products(pseudo):
    """Return the products (10,) of a pseudo-inertia in pinocchio's order."""
    tensor = np.trace(pseudo[:3, :3]) * np.eye(3) - pseudo[:3, :3]
    return np.array([pseudo[3, 3], *pseudo[:3, 3], tensor[0, 0], tensor[0, 1], tensor[1, 1],
                     tensor[0, 2], tensor[1, 2], tensor[2, 2]])


def true_arm(robot, seed=0):
    truth = draw_truth(robot, DEFAULT, np.random.default_rng(seed))
    links = np.concatenate([products(link) for link in truth.links])
    return Arm(robot, truth.links, truth.rotor, truth.gravity), truth, links


ROBOTS = [ur10e, lambda: chain('z', 'y', 'y', 'x'), lambda: chain(*'zyzyzyz'),
          lambda: chain('z', 'z', 'prismatic z', 's')]


@pytest.mark.parametrize('make', ROBOTS)
def test_torque_of_the_motion_is_inverse_dynamics_of_the_true_parameters(make):
    robot = make()
    arm, truth, links = true_arm(robot)
    rng = np.random.default_rng(1)
    arm.attach(LOAD)
    for _ in range(10):
        arm.position[:], arm.velocity[:] = rng.uniform(-1.0, 1.0, (2, robot.n))
        torque = rng.uniform(-20.0, 20.0, robot.n)
        q, v, a = arm.position.copy(), arm.velocity.copy(), arm.accelerate(torque).copy()
        expected = (robot.link_regressor(q, v, a) @ links + truth.rotor * a
                    + robot.load_regressor(q, v, a) @ LOAD.to_products())
        np.testing.assert_allclose(torque, expected, atol=1e-6)


@pytest.mark.parametrize('make', ROBOTS)
def test_attaching_a_load_changes_the_holding_torque_by_its_regressor(make):
    robot = make()
    arm, _, _ = true_arm(robot)
    q = np.random.default_rng(2).uniform(-0.5, 0.5, robot.n)
    arm.position[:] = q
    empty = arm.hold_torque()
    arm.attach(LOAD)
    rest = np.zeros(robot.n)
    gravity = robot.load_regressor(q, rest, rest) @ LOAD.to_products()
    np.testing.assert_allclose(arm.hold_torque() - empty, gravity, atol=1e-6)
    arm.attach(LoadParameters())
    np.testing.assert_allclose(arm.hold_torque(), empty, atol=1e-6)


def test_energy_of_a_free_swing_is_kept():
    """With no torque at all the arm neither gains nor loses energy beyond the step's error."""
    robot = chain('y', 'y', 'x')
    arm, truth, links = true_arm(robot)
    rest = np.zeros(robot.n)

    def energy():
        q, v = arm.position.copy(), arm.velocity.copy()
        columns = [robot.link_regressor(q, rest, e) @ links
                   - robot.link_regressor(q, rest, rest) @ links for e in np.eye(robot.n)]
        return 0.5 * v @ (np.array(columns).T + np.diag(truth.rotor)) @ v

    work = 0.0
    for _ in range(20000):
        gravity = arm.hold_torque()
        arm.accelerate(rest)
        arm.integrate(5e-5)
        work -= gravity @ arm.velocity * 5e-5
    assert energy() > 0.5
    assert energy() == pytest.approx(work, rel=2e-3)


@pytest.mark.parametrize('seed', range(5))
def test_true_links_are_bodies_within_the_stated_error(seed):
    robot = ur10e()
    truth = draw_truth(robot, DEFAULT, np.random.default_rng(seed))
    for j, link in enumerate(truth.links):
        nominal = robot.nominal_links[10 * j:10 * j + 10]
        true = products(link)
        assert np.linalg.eigvalsh(link)[0] > -1e-12
        assert 0.0 < abs(true[0] / nominal[0] - 1.0) <= DEFAULT.link_error
        com, was = true[1:4] / true[0], nominal[1:4] / nominal[0]
        assert np.linalg.norm(com - was) <= DEFAULT.link_error * np.linalg.norm(was) + 1e-12
