"""Estimator node: joint states and temperatures in, load with its covariance out."""

import sys
import time
import traceback

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import InertiaStamped
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64MultiArray, Header
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from ..errors import HandLoadError
from ..estimators.build import build_pipeline
from ..estimators.impossible_mass import impossible_mass
from ..estimators.pipeline import TareError
from ..estimators.suggest_motion import SuggestionError
from ..load import message_from_products
from ..robot import load_robot
from ..torque.model_of_robot import other_limits
from .checkpoint_keeper import CheckpointKeeper
from .command_line import run_from_command_line
from .controller_messages import trajectory_message
from .diagnostics import WARN, Diagnostics
from .draining import subscribe_draining
from .estimate_messages import (covariance_message, estimate_status, inertia_message,
                                residual_message, TOOL)
from .estimator_parameters import ESTIMATOR_PARAMETERS
from .input_report import InputReport
from .markers import estimate_markers
from .model_cautions import cautions
from .model_choice import robot_and_model
from .model_report import report_model, told_of_model
from .parameters import NodeParameters
from .qos import LATCHED, OUTPUT, measurement, publisher
from .stamps import StampBase
from .temperature_input import subscribe_dynamic_joint_states
from .throttle import Throttle

_STATUS_PERIOD = 0.1  # [s]
_CHECKPOINT_PERIOD = 1.0  # [s]


def build_from_parameters(values):
    """Return the Pipeline the parameters ask for; raises ConfigurationError."""
    robot, model = robot_and_model(values)
    return build_pipeline(model, values.method, values.learned or None, robot,
                          values.tool or None, values.intervals or None)


def limits_from_parameters(values, pipeline):
    """Return sentences on limits that the robot file states otherwise than the model's."""
    robot, _ = robot_and_model(values)
    return other_limits(pipeline.model.robot, load_robot(robot))


# A path nobody can have, as of an unknown user or too long, is found out by the system.
_WRONG_FILES = HandLoadError, OSError, RuntimeError


def _one_sentence(error):
    return ' '.join(str(error).split())


class EstimatorNode(Node):
    """Thin shell around estimators.Pipeline."""

    def __init__(self):
        super().__init__('estimator')
        self._declared = NodeParameters(self, ESTIMATOR_PARAMETERS, changed=self._set_rates)
        values = self._declared.values
        self._set_rates(values)
        self._use(build_from_parameters(values))
        self._checkpoint = CheckpointKeeper(values.checkpoint, values.checkpoint_max_age,
                                            self.get_fully_qualified_name())
        self._checkpoint.restore(self._pipeline)
        self._base, self._last_stamp = StampBase(), None
        self._newest = self._arrived = None
        self._last_status = self._drawn_next = None
        # By stamps, since simulated time may run faster than the clock on the wall; by that one
        # while they stop.
        self._status_throttle, self._told_lately = Throttle(1.0 / _STATUS_PERIOD), False
        self._input = InputReport()
        self._create_outputs()
        self._create_inputs(values)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_STATUS_PERIOD, self._keep_telling, clock=steady)
        self.create_timer(_CHECKPOINT_PERIOD, lambda: self._checkpoint.keep(self._pipeline),
                          clock=steady)
        self._create_diagnostics()
        self._known_told = None
        self._publish_known_load()
        self.get_logger().info(f'estimating the load of {self._robot.name} with '
                               f'{self._pipeline.method.name}, {told_of_model(self._pipeline)}; '
                               f'checkpoint: {self._checkpoint.told}')
        for caution in (*cautions(self._pipeline.model, self._simulated()),
                        *limits_from_parameters(values, self._pipeline)):
            self.get_logger().warning(caution)

    def _simulated(self):
        return self.get_parameter('use_sim_time').value

    def _use(self, pipeline):
        self._model_written = pipeline.model_file.stat().st_mtime
        self._pipeline, self._robot = pipeline, pipeline.model.robot
        self._joints = list(self._robot.joints)

    def _set_rates(self, values):
        self._outputs_throttle = Throttle(values.publish_rate)
        self._markers_throttle = Throttle(values.marker_rate) if values.marker_rate else None

    def _create_outputs(self):
        self._load = publisher(self, InertiaStamped, '~/load', OUTPUT)
        self._variance = publisher(self, InertiaStamped, '~/load_variance', OUTPUT)
        self._covariance = publisher(self, Float64MultiArray, '~/load_covariance', OUTPUT)
        self._residual = publisher(self, JointState, '~/residual_torque', OUTPUT)
        self._known = publisher(self, InertiaStamped, '~/known_load', LATCHED)
        self._markers = publisher(self, MarkerArray, '~/markers', OUTPUT)
        self._status = publisher(self, DiagnosticStatus, '~/status', LATCHED)
        self._suggested = publisher(self, JointTrajectory, '~/suggested_motion', LATCHED)

    def _create_inputs(self, values):
        subscribe_draining(self, JointState, 'joint_states', self._on_joint_state,
                           measurement(values.joint_states_depth))
        self.create_subscription(Temperature, 'joint_temperatures', self._on_temperature,
                                 measurement(values.temperatures_depth))
        subscribe_dynamic_joint_states(self, values.joint_states_depth, self._take_temperature)
        self.create_service(Trigger, '~/reset', self._on_reset)
        self.create_service(Trigger, '~/tare', self._on_tare)
        self.create_service(Trigger, '~/reload_model', self._on_reload_model)
        self.create_service(Trigger, '~/suggest_motion', self._on_suggest_motion)

    def _create_diagnostics(self):
        self._diagnostics = Diagnostics(self, hardware_id=self._robot.name)
        self._diagnostics.add('input', lambda: self._input.report(self._pipeline))
        self._diagnostics.add('estimate', self._report_estimate)
        self._diagnostics.add('model', lambda: report_model(
            self._pipeline, self._model_written, self._base, self._simulated()))
        self._diagnostics.add('checkpoint', self._checkpoint.report)

    def _on_joint_state(self, message):
        seconds = self._base.seconds(message.header.stamp)
        self._input.joint_state()
        estimate = self._pipeline.joint_state(seconds, message.name, message.position,
                                              message.velocity, message.effort)
        if self._pipeline.last_stamp != self._newest:
            self._newest, self._arrived = self._pipeline.last_stamp, time.monotonic()
        drawn_next, self._drawn_next = self._drawn_next, estimate
        if estimate is not None:
            self._publish_estimate(estimate)
        if drawn_next is not None:
            # A message later, so that whoever waits for the estimate runs first.
            self._pipeline.settle()
            self._draw(drawn_next)

    def _on_temperature(self, message):
        self._take_temperature(message.header.frame_id, message.temperature)

    def _take_temperature(self, joint, celsius):
        self._input.temperature(joint, self._joints)
        self._pipeline.temperature_reading(joint, celsius)

    def _publish_estimate(self, estimate):
        seconds, key = estimate.stamp, (estimate.status, estimate.load_id)
        self._last_stamp = seconds
        stamp, frame = self._base.message(seconds), self._robot.load_frame
        if self._outputs_throttle.due(seconds) or key != self._last_status:
            self._load.publish(inertia_message(estimate.mean, stamp, frame))
            self._variance.publish(inertia_message(estimate.std ** 2, stamp, frame))
            self._covariance.publish(covariance_message(estimate.covariance))
        # Whoever looks for collisions cannot do with fewer.
        self._residual.publish(residual_message(self._joints, self._pipeline.residual, stamp))
        if self._status_throttle.due(seconds) or key != self._last_status:
            self._publish_status()

    def _draw(self, estimate):
        if self._markers_throttle and self._markers_throttle.due(estimate.stamp):
            header = Header(stamp=self._base.message(estimate.stamp),
                            frame_id=self._robot.load_frame)
            self._markers.publish(estimate_markers(estimate, header))

    def _now(self):
        """Return the time [s] on the clock of the joint states, 0 before the first usable one."""
        # By what arrives and when: that clock and this node's need not agree.
        return 0.0 if self._newest is None else self._newest + time.monotonic() - self._arrived

    def _current(self):
        """Return the estimate as of now and the age of the newest measurement in it [s]."""
        now, newest = self._now(), self._last_stamp
        # A clock that was set back leaves no age of what was before.
        known = newest is not None and newest <= now
        return self._pipeline.estimate(now), now - newest if known else float('nan')

    def _keep_telling(self):
        if not self._told_lately:
            self._publish_status()
        self._told_lately = False

    def _publish_status(self):
        self._told_lately = True
        if not np.array_equal(self._known_told, self._pipeline.known_load):
            # What was tared is another arm's.
            self._publish_known_load()
        estimate, age = self._current()
        self._last_status = (estimate.status, estimate.load_id)
        name = self.get_fully_qualified_name().lstrip('/')
        self._status.publish(self._status_of(f'{name}: load', estimate, age))

    def _status_of(self, name, estimate, age):
        return estimate_status(name, estimate, age, self._pipeline.method.name,
                               self._pipeline.tared_mass,
                               {'intervals': self._pipeline.intervals,
                                TOOL: self._pipeline.tool_mass,
                                'checkpoint': self._checkpoint.told,
                                **self._pipeline.reliability})

    def _report_estimate(self):
        estimate, age = self._current()
        status = self._status_of('', estimate, age)
        values = [(pair.key, pair.value) for pair in status.values]
        values += [('samples', self._pipeline.samples), ('mass [kg]', float(estimate.mean[0])),
                   ('mass std [kg]', float(estimate.std[0]))]
        level = (max(status.level, WARN)
                 if impossible_mass(estimate, self._pipeline.tared_mass) else status.level)
        return level, f'{estimate.status} {estimate.reason}'.strip(), values

    def _on_reset(self, _request, response):
        self._pipeline.reset()
        self._after_request()
        response.success, response.message = True, f'the load is forgotten{self._told_of_tare()}'
        return response

    def _told_of_tare(self):
        if not self._pipeline.method.tared.any():
            return ''
        return (f'; the tare of {self._pipeline.tared_mass:.3f} kg stays: ~/reload_model drops '
                'it, or a new start without a checkpoint')

    def _on_tare(self, _request, response):
        try:
            self._pipeline.tare(self._now())
        except TareError as error:
            response.success, response.message = False, str(error)
            return response
        self._after_request()
        response.success, response.message = True, 'what is held now counts as zero'
        return response

    def _on_suggest_motion(self, _request, response):
        try:
            suggestion = self._pipeline.suggest_motion(self._now())
        except SuggestionError as error:
            response.success, response.message = False, str(error)
            return response
        # Without points where there is nothing to do, so that no old suggestion stays latched.
        message = JointTrajectory(joint_names=self._joints)
        if suggestion.trajectory is not None:
            message = trajectory_message(self._joints, suggestion.trajectory)
        self._suggested.publish(message)
        response.success, response.message = True, suggestion.text()
        return response

    def _on_reload_model(self, _request, response):
        values, old = self._declared.values, self._pipeline
        try:
            new = build_from_parameters(values)
            self._use(new)
        # Whatever is wrong with the files, the old model is at work and shall stay so.
        except Exception as error:
            told = _one_sentence(error)
            if not isinstance(error, _WRONG_FILES):
                told = f'{type(error).__name__}: {told}'
                self.get_logger().error(traceback.format_exc())
            response.success = False
            response.message = (f'{told}; the model that was read from '
                                f'{old.model_file} stays at work')
            self.get_logger().warning(f'model refused: {response.message}')
            return response
        new.take_over(old)
        self._after_request()
        response.success, response.message = True, self._told_of_reload(old)
        self.get_logger().info(response.message)
        return response

    def _after_request(self):
        """Tell at once, and keep: a kill must not undo what was asked for."""
        self._checkpoint.keep(self._pipeline, even_if_old=True)
        self._publish_known_load()
        self._publish_status()

    def _publish_known_load(self):
        self._known_told = self._pipeline.known_load
        self._known.publish(inertia_message(
            message_from_products(self._known_told),
            self.get_clock().now().to_msg(), self._robot.load_frame))

    def stop(self):
        """Write the last checkpoint."""
        self._checkpoint.stop(self._pipeline)

    def _told_of_reload(self, old):
        tare = ' and the tare is dropped, tare again' if old.method.tared.any() else ''
        return f'{self._pipeline.model_file} is at work; the load is found anew{tare}'


def main(args=None):
    """Run the node; return the exit code."""
    return run_from_command_line('estimator', EstimatorNode, ESTIMATOR_PARAMETERS, args)


if __name__ == '__main__':
    sys.exit(main())
