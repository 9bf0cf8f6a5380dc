"""A torque model, loads and an arm for the tests of room control/."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin

from hand_load_estimator.control.load_belief import belief_of_estimate
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.motions.trajectory import Trajectory
from hand_load_estimator.robot import load_robot
from hand_load_estimator.torque.columns import ColumnLayout

HOME = np.array([0.0, -1.8, 2.5, -2.27, -1.57, 0.0])
PICK = np.array([0.7, -1.25, 2.2, -2.52, -1.57, 0.7])
PLACE = np.array([-0.9, -1.3, 1.75, -2.02, -1.57, -0.5])
# Far out: here the load decides what the arm can do.
FAR_PICK = np.array([0.7, -1.2, 1.9, -2.27, -1.57, 0.7])
FAR_PLACE = np.array([-0.6, -0.9, 1.3, -1.97, -1.57, -0.5])
WARM = np.full(6, 25.0)


class FakeModel:
    """
    Nominal rigid body with Coulomb and viscous friction, as an identified model has.

    agility: times the robot file's accelerations, so that the torques and not they decide.
    """

    noise = np.array([1.2, 1.2, 0.9, 0.35, 0.35, 0.35])
    coulomb = np.array([9.0, 9.0, 6.0, 2.0, 2.0, 2.0])
    viscous = np.array([12.0, 12.0, 8.0, 2.0, 2.0, 2.0])
    # Known exactly, and the same at every temperature.
    uses, mean, covariance = (), np.zeros(60), np.zeros((60, 60))
    layout = ColumnLayout(6, ())
    residuals = SimpleNamespace(drift=np.zeros((6, 3)))

    def __init__(self, agility=1.0):
        self.robot = load_robot(find_shared('ur10e', 'robots'))
        limits = self.robot.limits
        self.robot.limits = replace(limits, acceleration=agility * limits.acceleration)

    def torque(self, q, v, a, temperature=None):
        """Return the torque (n,) without load."""
        return self.robot.rigid_torque(q, v, a) + self.coulomb * np.sign(v) + self.viscous * v

    def load_regressor(self, q, v, a):
        """Return K (n, 10)."""
        return self.robot.load_regressor(q, v, a)

    def load_while_sliding(self, q, v, a, temperature, products):
        """Return K (n, 10) and no torque (n,) beside: friction does not depend on the load."""
        return self.load_regressor(q, v, a), np.zeros(6)

    def slices(self):
        """Return the effects with their columns: none."""
        return []


def load_vector(mass, com=(0.0, 0.0, 0.1)):
    """Return a load in message order: a body about 0.2 m in size."""
    inertia = 0.01 * mass
    return np.array([mass, *com, inertia, 0.0, 0.0, inertia, 0.0, inertia])


def covariance_of(mass_std, com_std=0.005, inertia_std=0.005):
    """Return a diagonal covariance in message order."""
    return np.diag(np.array([mass_std] + [com_std] * 3 + [inertia_std] * 6) ** 2)


def belief(mass, mass_std=0.05, com=(0.0, 0.0, 0.1), **spread):
    """Return the LoadBelief of an estimate."""
    return belief_of_estimate(load_vector(mass, com), covariance_of(mass_std, **spread))


def torque_with_load(model, vector, q, v, a):
    """Return the torque (n,) by rnea on a model whose last link carries the load."""
    robot = model.robot
    loaded = pin.Model(robot.model)
    frame = loaded.frames[loaded.getFrameId(robot.load_frame)]
    tensor = np.array([[vector[4], vector[5], vector[6]], [vector[5], vector[7], vector[8]],
                       [vector[6], vector[8], vector[9]]])
    body = pin.Inertia(float(vector[0]), np.array(vector[1:4]), tensor)
    loaded.inertias[robot.n] = loaded.inertias[robot.n] + frame.placement.act(body)
    friction = model.torque(q, v, a) - robot.rigid_torque(q, v, a)
    return pin.rnea(loaded, loaded.createData(), q, v, a) + friction


class FakeArm:
    """Follows trajectories exactly, as ros2_control's controller would command them."""

    def __init__(self, model, position):
        self._model, self.load = model, np.zeros(10)
        self._plan, self._rest = None, np.array(position, dtype=float)
        self.push = np.zeros(len(self._rest))
        self.taken = 0

    def state(self, now):
        """Return q, v, a (n,) at `now` [s]."""
        if self._plan is None:
            return self._rest, np.zeros_like(self._rest), np.zeros_like(self._rest)
        return self._plan.sample(now)

    def take(self, trajectory, now):
        """Follow a trajectory whose time 0 is now, joined to the present set-point."""
        first = self.state(now)
        later = trajectory.time > 1e-6
        self._plan = Trajectory(
            np.concatenate([[now], now + trajectory.time[later]]),
            *(np.vstack([start, column[later]]) for start, column in zip(
                first, (trajectory.position, trajectory.velocity, trajectory.acceleration))))
        self.taken += 1

    def residual(self, now):
        """Return the torque (n,) that the model without load leaves over."""
        return self._model.robot.load_regressor(*self.state(now)) @ self.load + self.push
