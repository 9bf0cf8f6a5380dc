"""A small robot and estimator as topics for the controller's process, and what it says."""

from types import SimpleNamespace

from control_helpers import covariance_of, FakeArm, FakeModel, HOME, load_vector, PICK
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import InertiaStamped
import numpy as np
from ros_helpers import CONTROLLER_YAML
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory

from hand_load_estimator.identification.identify import nominal_model
from hand_load_estimator.load import products_from_message
from hand_load_estimator.motions.trajectory import Trajectory
from hand_load_estimator.nodes.estimate_messages import (covariance_message, inertia_message,
                                                         residual_message)
from hand_load_estimator.nodes.qos import LATCHED, measurement, OUTPUT
from hand_load_estimator.torque.model_file import write_model

MODEL = FakeModel()
JOINTS = list(MODEL.robot.joints)
RATE = 100.0
MASS = 2.0


class Robot:
    """Follows trajectories and publishes joint states, an estimate, a status and residuals."""

    def __init__(self, node, prefix=''):
        self._node, self.arm, self.refused = node, FakeArm(MODEL, HOME), []
        self.residuals, self.tared = True, False
        self.arm.load, self.order = products_from_message(load_vector(MASS)), list(range(6))
        self._states = node.create_publisher(JointState, f'{prefix}joint_states', OUTPUT)
        self._load = node.create_publisher(InertiaStamped, f'{prefix}estimator/load', OUTPUT)
        self._variance = node.create_publisher(InertiaStamped, f'{prefix}estimator/load_variance',
                                               OUTPUT)
        self._covariance = node.create_publisher(
            Float64MultiArray, f'{prefix}estimator/load_covariance', OUTPUT)
        self._status = node.create_publisher(DiagnosticStatus, f'{prefix}estimator/status',
                                             LATCHED)
        self._residual = node.create_publisher(JointState, f'{prefix}estimator/residual_torque',
                                               OUTPUT)
        self._known = node.create_publisher(InertiaStamped, f'{prefix}estimator/known_load',
                                            LATCHED)
        node.create_subscription(
            JointTrajectory, f'{prefix}joint_trajectory_controller/joint_trajectory',
            self._take, OUTPUT)
        node.create_timer(1.0 / RATE, self.publish)
        self.received = []

    def now(self):
        """Return the time [s]."""
        return self._node.get_clock().now().nanoseconds * 1e-9

    def _take(self, message):
        self.received.append(message)
        if not message.points or list(message.joint_names) != JOINTS:
            self.refused.append(message)
            return
        time = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in message.points]
        columns = [[getattr(p, kind) for p in message.points]
                   for kind in ('positions', 'velocities', 'accelerations')]
        state = self.arm.state(self.now())
        self.arm.take(Trajectory([0.0, *time], *(np.vstack([first, column]) for first, column in
                                                 zip(state, columns))), self.now())

    def publish(self):
        """Publish one joint state and what an estimator would say of it."""
        stamp = self._node.get_clock().now().to_msg()
        q, v, _ = self.arm.state(self.now())
        message = JointState(name=[JOINTS[i] for i in self.order], position=q[self.order].tolist(),
                             velocity=v[self.order].tolist(), effort=[0.0] * 6)
        message.header.stamp = stamp
        self._states.publish(message)
        held, zero = load_vector(MASS), np.zeros(10)
        self._load.publish(inertia_message(zero if self.tared else held, stamp, 'tool0'))
        self._known.publish(inertia_message(held if self.tared else zero, stamp, 'tool0'))
        covariance = covariance_of(0.05)
        self._variance.publish(inertia_message(np.diag(covariance), stamp, 'tool0'))
        self._covariance.publish(covariance_message(covariance))
        self._status.publish(DiagnosticStatus(message='DETERMINED', values=[
            KeyValue(key='load_id', value='1'),
            KeyValue(key='tared mass [kg]', value=str(MASS * self.tared))]))
        if self.residuals:
            self._residual.publish(residual_message(
                JOINTS, self.arm.residual(self.now()), stamp))


def listening(listener, prefix=''):
    """Return what the controller says, as growing lists."""
    at = f'{prefix}controller/'
    return SimpleNamespace(
        phase=listener.listen(String, f'{at}phase', LATCHED),
        limits=listener.listen(JointTrajectory, f'{at}motion_limits', LATCHED),
        thresholds=listener.listen(JointState, f'{at}collision_thresholds', measurement(1000)),
        collision=listener.listen(Bool, f'{at}collision', LATCHED),
        diagnostics=listener.listen(DiagnosticArray, '/diagnostics', OUTPUT))


def plain_model(folder):
    """Return the path of a torque model of the UR10e without friction, written to a folder."""
    path = folder / 'plain.yaml'
    write_model(path, nominal_model(MODEL.robot, 0.02 * FakeModel.noise ** 2))
    return path


def arguments(model_file, **parameters):
    """Return the command line: short dwells and other parameters."""
    values = {'model': model_file, 'dwell': 0.3, 'home_dwell': 0.2, 'autostart': 'true',
              **parameters}
    return ['--ros-args', '--params-file', CONTROLLER_YAML, *(
        part for name, value in values.items() for part in ('-p', f'{name}:={value}'))]


def phases(heard):
    return [message.data for message in heard.phase]


def brakes(message):
    """Return whether a trajectory on the way to PICK ends at rest somewhere before."""
    last = message.points[-1]
    return not np.any(last.velocities) and np.max(np.abs(np.array(last.positions) - PICK)) > 0.02
