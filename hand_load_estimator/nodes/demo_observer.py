"""What the demo sees and does over ROS: listens to all three nodes, grips and lets go."""

import time
from collections import defaultdict

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import InertiaStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import String
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from .estimate_messages import vector_of_inertia
from .qos import LATCHED, OUTPUT, measurement
from .stamps import StampBase


class DemoObserver:
    """
    A node in the demo's own process.

    series: name -> list of (time [s], value); load and variance (10,) in message order,
    truth (10,), residual (n,), temperature (joint, degC), status (text, reason), phase (text).
    refusal: why the simulator did not take the load, else empty.
    limits: (2, n) largest accelerations while accelerating and decelerating [rad/s^2], or None.
    Time counts from the first stamp seen. Use as a context manager.
    """

    def __init__(self):
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node('demo', parameter_overrides=[Parameter('use_sim_time', value=True)])
        self.series, self.limits, self.joints = defaultdict(list), None, ()
        self._base = StampBase()
        self._attach = self.node.create_client(SetBool, 'simulator/attach_load')
        self.refusal = ''
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._subscribe()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown()

    def _subscribe(self):
        def stamped(name, value):
            return lambda message: self._add(name, message.header.stamp, value(message))

        def inertia(message):
            return np.array(vector_of_inertia(message.inertia))

        listen = self.node.create_subscription
        listen(InertiaStamped, 'estimator/load', stamped('load', inertia), OUTPUT)
        listen(InertiaStamped, 'estimator/load_variance', stamped('variance', inertia), OUTPUT)
        listen(InertiaStamped, 'simulator/true_load', stamped('truth', inertia), LATCHED)
        listen(JointState, 'estimator/residual_torque', self._on_residual, OUTPUT)
        listen(Temperature, 'joint_temperatures',
               stamped('temperature', lambda m: (m.header.frame_id, m.temperature)),
               measurement(100))
        listen(DiagnosticStatus, 'estimator/status', self._on_status, LATCHED)
        listen(String, 'controller/phase', self._on_phase, LATCHED)
        listen(JointTrajectory, 'controller/motion_limits', self._on_limits, LATCHED)

    def _add(self, name, stamp, value):
        self.series[name].append((self._base.seconds(stamp), value))

    def _add_now(self, name, value):
        now = self.node.get_clock().now()
        # Latched messages may come before the first /clock; they then belong to the beginning.
        at = self._base.seconds(now.to_msg()) if now.nanoseconds else 0.0
        self.series[name].append((at, value))

    def _on_residual(self, message):
        self.joints = tuple(message.name)
        self._add('residual', message.header.stamp, np.array(message.effort))

    def _on_status(self, message):
        values = {pair.key: pair.value for pair in message.values}
        self._add_now('status', (message.message, values))

    def _on_phase(self, message):
        if self.phase != message.data:
            self._add_now('phase', message.data)

    def _on_limits(self, message):
        self.limits = np.array([point.accelerations for point in message.points])

    @property
    def phase(self):
        """The controller's phase, empty before it has said one."""
        return self.series['phase'][-1][1] if self.series['phase'] else ''

    def last(self, name):
        """Return the newest value of a series, or None."""
        return self.series[name][-1][1] if self.series[name] else None

    def hold(self, gripped):
        """Close or open the hand, as a gripper would at the pick and the place position."""
        self._attach.call_async(SetBool.Request(data=gripped)).add_done_callback(self._answered)

    def _answered(self, future):
        if not future.result().success:
            self.refusal = future.result().message

    def spin(self, seconds):
        """Listen for some real time [s]."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)
