"""Controller node: a pick-and-place cycle whose limits and thresholds follow the load."""

import sys
import time
from collections import Counter
from types import SimpleNamespace

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import InertiaStamped
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Bool, Float64MultiArray, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from ..control.fallback import usable_estimate
from ..control.supervisor import Supervisor
from ..load import products_from_message
from ..stream.input_guard import InputGuard
from ..stream.joint_temperatures import JointTemperatures
from .command_line import run_from_command_line
from .controller_messages import (effort_by_name, limits_message, thresholds_message,
                                  trajectory_message)
from .controller_parameters import CONTROLLER_PARAMETERS
from .controller_report import (report_collision, report_load, report_motion,
                                report_torque_model)
from .controller_settings import model_from_parameters, settings_from_parameters
from .diagnostics import Diagnostics
from .draining import subscribe_draining
from .estimate_messages import KNOWN_MASSES, vector_of_inertia
from .input_report import InputReport
from .load_pairing import LoadPairing
from .model_cautions import cautions
from .model_choice import robot_and_model
from .parameters import NodeParameters
from .qos import LATCHED, OUTPUT, measurement
from .stamps import ClockOffset, StampBase
from .temperature_input import subscribe_dynamic_joint_states

_LAST_WORDS = 0.5  # [s] at most, for the last trajectory to be received
_RESTING = 5  # thresholds at rest are published every this many cycles


class ControllerNode(Node):
    """Thin shell around control.Supervisor."""

    def __init__(self):
        super().__init__('controller')
        values = NodeParameters(self, CONTROLLER_PARAMETERS).values
        model = model_from_parameters(values)
        self._robot = model.robot
        self._simulated = self.get_parameter('use_sim_time').value
        self._supervisor = Supervisor(model, settings_from_parameters(values, model.robot))
        self._model, self._guard, self._input = model, InputGuard(self._robot), InputReport()
        self._rejected, self._base, self._offset = Counter(), StampBase(), ClockOffset()
        self._temperatures = JointTemperatures(self._robot.joints)
        self._supervisor.temperature = self._temperatures.values
        self._pairing, self._ticks = LoadPairing(), 0
        self._said = {}
        self._create_outputs()
        self._create_inputs(values)
        self._create_diagnostics()
        # Where the wall clock is set back, a timer of that clock would wait for it to catch up.
        self.create_timer(1.0 / values.rate, self._tick, clock=None if self._simulated
                          else Clock(clock_type=ClockType.STEADY_TIME))
        if values.autostart:
            self._supervisor.start()
        self._say_changes()
        self.get_logger().info(
            f'controlling {self._robot.name} with {robot_and_model(values)[1]}; ' + (
                'moves as soon as joint states come' if values.autostart else
                'moves after ~/start'))

    def _create_outputs(self):
        self._trajectory = self.create_publisher(
            JointTrajectory, 'joint_trajectory_controller/joint_trajectory', OUTPUT)
        self._limits = self.create_publisher(JointTrajectory, '~/motion_limits', LATCHED)
        self._thresholds = self.create_publisher(JointState, '~/collision_thresholds', LATCHED)
        self._collision = self.create_publisher(Bool, '~/collision', LATCHED)
        self._phase = self.create_publisher(String, '~/phase', LATCHED)

    def _create_inputs(self, values):
        subscribe_draining(self, JointState, 'joint_states', self._on_joint_state,
                           measurement(values.joint_states_depth))
        self.create_subscription(Temperature, 'joint_temperatures', self._on_temperature,
                                 measurement(values.temperatures_depth))
        subscribe_dynamic_joint_states(self, values.joint_states_depth, self._take_temperature)
        self.create_subscription(InertiaStamped, 'estimator/load', self._on_load, OUTPUT)
        self.create_subscription(InertiaStamped, 'estimator/load_variance', self._on_variance,
                                 OUTPUT)
        self.create_subscription(Float64MultiArray, 'estimator/load_covariance',
                                 self._on_covariance, OUTPUT)
        self.create_subscription(InertiaStamped, 'estimator/known_load', self._on_known_load,
                                 LATCHED)
        self.create_subscription(DiagnosticStatus, 'estimator/status', self._on_status, LATCHED)
        self.create_subscription(JointState, 'estimator/residual_torque', self._on_residual,
                                 measurement(100))
        self.create_service(Trigger, '~/start', self._on_start)
        self.create_service(Trigger, '~/reset', self._on_reset)

    def _create_diagnostics(self):
        self._diagnostics = Diagnostics(self, hardware_id=self._robot.name)
        self._diagnostics.add('motion', lambda: report_motion(
            self._supervisor, self._trajectory.get_subscription_count() > 0, not self._no_clock))
        self._diagnostics.add('load', lambda: report_load(self._supervisor.policy))
        self._diagnostics.add('collision', lambda: report_collision(self._supervisor))
        self._diagnostics.add('input', self._report_input)
        self._diagnostics.add('model', lambda: report_torque_model(self._model, self._simulated))
        for caution in cautions(self._model, self._simulated):
            self.get_logger().warning(caution)

    def _now(self):
        return self._base.seconds(self.get_clock().now().to_msg())

    def _steady(self):
        """Return a time [s] that nobody sets; None in a simulation, which has its own pace."""
        return None if self._simulated else time.monotonic()

    def _on_joint_state(self, message):
        stamp = self._base.seconds(message.header.stamp)
        self._input.joint_state()
        # The controller does not read the effort; a joint without one still has a position.
        accepted = self._guard.accept(stamp, message.name, message.position, message.velocity,
                                      [0.0] * len(message.name))
        if accepted is None:
            return
        q, v, _ = accepted
        if self._no_clock:
            return
        if self._guard.restarted:
            self._offset.restart()
        # When it was measured, in this node's time: one that has waited in a queue is old.
        self._supervisor.measured(
            self._offset.update(self._now(), stamp, self._steady()), q, v)

    def _on_temperature(self, message):
        self._take_temperature(message.header.frame_id, message.temperature)

    def _take_temperature(self, joint, celsius):
        self._input.temperature(joint, self._robot.joints)
        self._temperatures.take(joint, celsius, self._guard.names)

    def _on_load(self, message):
        if self._in_load_frame(message):
            self._take_estimate(self._pairing.mean(*_stamped_vector(message)))

    def _on_variance(self, message):
        if self._in_load_frame(message):
            self._take_estimate(self._pairing.variance(*_stamped_vector(message)))

    def _in_load_frame(self, message):
        """Tell whether a load is told in the frame of this node's robot file; count others."""
        if message.header.frame_id == self._robot.load_frame:
            return True
        self._rejected['estimate_frame'] += 1
        return False

    def _on_covariance(self, message):
        covariance = np.array(message.data)
        if covariance.size != 100:
            self._rejected['estimate_size'] += 1
        elif not np.isfinite(covariance).all():
            self._rejected['estimate_not_finite'] += 1
        else:
            self._take_estimate(self._pairing.covariance(covariance.reshape(10, 10)))

    def _take_estimate(self, estimate):
        if estimate is None:
            return
        unusable = usable_estimate(*estimate, self._supervisor.policy.known[0])
        if unusable:
            self._rejected[unusable] += 1
        else:
            self._supervisor.policy.estimate(self._now(), *estimate)

    def _on_known_load(self, message):
        vector = np.array(vector_of_inertia(message.inertia))
        if not self._in_load_frame(message):
            return
        if np.isfinite(vector).all():
            self._supervisor.policy.known = products_from_message(vector)
        else:
            self._rejected['known_load_not_finite'] += 1

    def _on_status(self, message):
        values = {pair.key: pair.value for pair in message.values}
        self._supervisor.policy.status(
            self._now(), message.message, values.get('load_id', ''), _known_mass(values))

    def _on_residual(self, message):
        torque = effort_by_name(message, self._robot.joints)
        if torque is None:
            self._rejected['residual_joints'] += 1
        elif not np.isfinite(torque).all():
            self._rejected['residual_not_finite'] += 1
        else:
            self._supervisor.residual(
                self._offset.here(self._base.seconds(message.header.stamp)), torque)

    def _on_start(self, _request, response):
        refused = self._supervisor.start()
        self._say_changes()
        response.success = not refused
        response.message = refused or f'goes on with {self._supervisor.phase}'
        return response

    def _on_reset(self, _request, response):
        self._supervisor.reset()
        self._say_changes()
        response.success = True
        response.message = f'{self._supervisor.phase}; ~/start goes on with the cycle'
        return response

    @property
    def _no_clock(self):
        """Whether use_sim_time is set and /clock has not arrived."""
        return self.get_clock().now().nanoseconds == 0

    def _tick(self):
        if self._no_clock:
            return
        now = self._now()
        self._temperatures.expire(now, self._guard.names)
        ready = self._trajectory.get_subscription_count() > 0
        self._send(self._supervisor.tick(now, ready))
        self._say_changes()
        self._ticks += 1
        in_force = self._supervisor.in_force
        if in_force is not None and (self._supervisor.moving or self._ticks % _RESTING == 0):
            self._thresholds.publish(thresholds_message(
                self._robot.joints, in_force.threshold, self.get_clock().now().to_msg()))

    def _send(self, trajectory):
        if trajectory is not None:
            self._trajectory.publish(trajectory_message(self._robot.joints, trajectory))

    def _say_changes(self):
        """Publish latched facts when they differ from what was said last."""
        supervisor = self._supervisor
        if self._changed('phase', supervisor.phase):
            self._phase.publish(String(data=supervisor.phase))
            self.get_logger().info(f'phase {supervisor.phase} {supervisor.stop_reason}'.strip())
        if self._changed('collision', supervisor.detector.collided):
            self._collision.publish(Bool(data=supervisor.detector.collided))
        if self._changed('limits', supervisor.limits):
            self._limits.publish(limits_message(self._robot.joints, supervisor.limits,
                                                self.get_clock().now().to_msg()))

    def _changed(self, what, value):
        before, self._said[what] = self._said.get(what), value
        return before != value

    def _report_input(self):
        rejected = self._guard.rejected + self._rejected + self._temperatures.rejected
        if self._pairing.unpaired:
            rejected['covariance_without_load'] = self._pairing.unpaired
        return self._input.report(SimpleNamespace(
            rejected=rejected, temperature=self._supervisor.temperature, model=self._model,
            passed_over=self._guard.passed_over, last_stamp=self._guard.last_stamp,
            why_none=self._guard.why_none, names=self._guard.names,
            # Without efforts, whose noise tells, nobody knows.
            velocity_stuck=self._guard.velocity_stuck, frozen=0.0,
            temperature_names=self._temperatures.names))

    def stop(self):
        """End a motion under way with a braking trajectory."""
        self._send(self._supervisor.stop())
        # Destroyed at once, a publisher may take its last message with it.
        self._trajectory.wait_for_all_acked(Duration(seconds=_LAST_WORDS))


def _known_mass(values):
    """Return the mass [kg] that a status tells of beside the estimate, NaN if it is no number."""
    try:
        return sum(float(values.get(key, 0.0)) for key in KNOWN_MASSES)
    except ValueError:
        return float('nan')


def _stamped_vector(message):
    """Return stamp and vector (10,) of an InertiaStamped."""
    stamp = message.header.stamp
    return (stamp.sec, stamp.nanosec), vector_of_inertia(message.inertia)


def main(args=None):
    """Run the node; return the exit code."""
    return run_from_command_line('controller', ControllerNode, CONTROLLER_PARAMETERS, args)


if __name__ == '__main__':
    sys.exit(main())
