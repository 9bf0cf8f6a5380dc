"""Simulator node: the plant behind the topics of a real arm."""

import sys
import time
from array import array
from collections import Counter

import numpy as np
from geometry_msgs.msg import InertiaStamped
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage
from sensor_msgs.msg import JointState, Temperature
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from ..errors import ConfigurationError
from ..files.shared_files import find_shared
from ..load import LoadParameters
from ..plant import Plant, read_effects, refuse_runaway
from ..robot import load_robot
from .command_line import run_from_command_line
from .diagnostics import ERROR, OK, WARN, Diagnostics
from .estimate_messages import inertia_message
from .pace import Pace
from .parameters import NodeParameters
from .qos import LATCHED, OUTPUT, publisher
from .simulator_parameters import SIMULATOR_PARAMETERS
from .stamps import time_message

_TICK = 0.002  # [s] real time between two looks at the clock
_LONGEST_TICK = 0.02  # [s] real
_TEMPERATURE_PERIOD = 0.1  # [s]
_CLOCK_PERIOD = 0.004  # [s] as often as controllers ask for the time
_NO_BODY = ('parameters load.mass, load.com, load.inertia describe no real body: the principal '
            'moments must satisfy the triangle inequality, and all be zero for a zero mass')


def plant_from_parameters(values):
    """Return (Robot, Plant) the parameters ask for; raises ConfigurationError."""
    robot = load_robot(find_shared(values.robot, 'robots'))
    effects = read_effects(values.hidden_effects, robot) if values.hidden_effects else ()
    plant = Plant(robot, seed=values.plant_seed, start_temperature=values.start_temperature,
                  ambient_temperature=values.ambient_temperature, effects=effects,
                  rate=values.rate)
    return robot, plant


def load_from_parameters(values):
    """Return LoadParameters of load.mass, load.com, load.inertia."""
    return LoadParameters.from_message([values.load_mass, *values.load_com,
                                        *values.load_inertia])


class SimulatorNode(Node):
    """Steps the plant in real time and publishes what an arm's driver would."""

    def __init__(self):
        super().__init__('simulator')
        self._declared = NodeParameters(self, SIMULATOR_PARAMETERS, changed=self._change_pace)
        values = self._declared.values
        self._robot, self._plant = plant_from_parameters(values)
        self._joints = list(self._robot.joints)
        # Starting at the present time, a restarted simulator does not turn the clock back.
        self._epoch = time.time_ns() - int(self._plant.time * 1e9)
        self._period = 1.0 / values.rate
        self._pace = Pace(values.real_time_factor)
        self._samples, self._taken, self._ended = 0, 0, ''
        self._refused, self._refused_before = Counter(), 0
        self._next_temperature = self._next_clock = 0.0
        self._create_interface()
        self._publish_true_load()
        self._timer = self.create_timer(_TICK, self._tick,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _create_interface(self):
        self._joint_states = publisher(self, JointState, 'joint_states', OUTPUT)
        self._temperatures = publisher(self, Temperature, 'joint_temperatures', OUTPUT)
        self._clock_topic = publisher(self, ClockMessage, '/clock', OUTPUT)
        self._true_load = publisher(self, InertiaStamped, '~/true_load', LATCHED)
        self.create_subscription(JointTrajectory, 'joint_trajectory_controller/joint_trajectory',
                                 self._on_trajectory, OUTPUT)
        self.create_service(SetBool, '~/attach_load', self._on_attach)
        self._diagnostics = Diagnostics(self, hardware_id=self._robot.name)
        self._diagnostics.add('clock', self._report_clock)
        self._diagnostics.add('trajectories', self._report_trajectories)

    def _change_pace(self, values):
        if values.real_time_factor != self._pace.factor:
            self._pace.set_factor(values.real_time_factor, time.monotonic(), self._plant.time)

    def _stamp(self):
        return time_message(self._epoch + int(round(self._plant.time * 1e9)))

    def _tick(self):
        started = time.monotonic()
        target = self._pace.target(started, self._plant.time)
        while (self._samples + 1) * self._period <= target + 1e-9:
            self._samples += 1
            # What overflows is told in one sentence.
            with np.errstate(all='ignore'):
                self._plant.step_until(self._samples * self._period)
            try:
                refuse_runaway(self._plant)
            except ConfigurationError as error:
                self._end(str(error))
                return
            self._publish_measurement()
            # Trajectories and services wait meanwhile.
            if time.monotonic() - started > _LONGEST_TICK:
                break

    def _end(self, why):
        """Publish no more of an arm that there cannot be."""
        self._ended = why
        self._timer.cancel()
        self.get_logger().fatal(f'simulation ended: {why}')
        self._diagnostics.publish()

    def _publish_measurement(self):
        stamp, now = self._stamp(), self._plant.time
        if now >= self._next_clock:
            self._next_clock = now + _CLOCK_PERIOD - 0.5 * self._period
            self._clock_topic.publish(ClockMessage(clock=stamp))
        position, velocity, effort = self._plant.measure()
        message = JointState(name=self._joints, position=array('d', position.tobytes()),
                             velocity=array('d', velocity.tobytes()),
                             effort=array('d', effort.tobytes()))
        message.header.stamp = stamp
        self._joint_states.publish(message)
        if now >= self._next_temperature:
            self._next_temperature = now + _TEMPERATURE_PERIOD - 0.5 * self._period
            self._publish_temperatures(stamp)

    def _publish_temperatures(self, stamp):
        for joint, celsius in zip(self._joints, self._plant.measure_temperatures()):
            message = Temperature(temperature=float(celsius))
            message.header.stamp, message.header.frame_id = stamp, joint
            self._temperatures.publish(message)

    def _on_trajectory(self, message):
        try:
            if self._ended:
                raise ValueError('the simulation has ended')
            self._plant.set_trajectory(*self._checked(message))
            self._taken += 1
        except (ValueError, ConfigurationError) as error:
            self._refused[str(error)] += 1
            self.get_logger().warning(f'trajectory refused: {error}',
                                      throttle_duration_sec=1.0)

    def _checked(self, message):
        """Return names, times, positions, velocities, accelerations; ValueError if unusable."""
        points = message.points
        if not points:
            raise ValueError('the trajectory is empty')
        times = np.array([p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec
                          for p in points])
        stamp = message.header.stamp
        if stamp.sec or stamp.nanosec:
            start = (stamp.sec * 10**9 + stamp.nanosec - self._epoch) * 1e-9
            times = times + start - self._plant.time
        ahead = times > 0.0
        if not ahead.any():
            # A single point at time zero means `be there now`, and a controller takes it.
            if times[-1] < 0.0:
                raise ValueError('the trajectory ends in the past')
            times, ahead = times + self._period, times >= 0.0
        rows = [p for p, keep in zip(points, ahead) if keep]
        position, velocity, acceleration = (_rows(rows, kind, len(message.joint_names))
                                            for kind in ('positions', 'velocities',
                                                         'accelerations'))
        if position is None:
            raise ValueError('a point has no positions')
        return list(message.joint_names), times[ahead], position, velocity, acceleration

    def _on_attach(self, request, response):
        load = load_from_parameters(self._declared.values) if request.data else None
        response.success = not self._ended and (load is None or load.is_physical())
        if not response.success:
            response.message = self._ended and f'the simulation has ended: {self._ended}' \
                or _NO_BODY
            return response
        self._plant.attach(load)
        self._publish_true_load()
        response.message = f'a load of {load.mass:g} kg hangs on the arm' if load \
            else 'the hand is empty'
        self.get_logger().info(response.message)
        return response

    def _publish_true_load(self):
        vector = self._plant.true_load.to_message()
        self._true_load.publish(inertia_message(vector, self._stamp(), self._robot.load_frame))

    def _report_clock(self):
        self._pace.count(time.monotonic(), self._plant.time)
        achieved, wanted = self._pace.achieved, self._pace.factor
        values = {'real time factor': achieved, 'wanted real time factor': wanted,
                  'simulated seconds': self._plant.time}
        if self._ended:
            return ERROR, f'simulation ended: {self._ended}', values
        if achieved < 0.97 * wanted:
            return WARN, f'this machine keeps up {achieved:.2f} of {wanted:g} wanted', values
        return OK, 'the clock keeps its pace', values

    def _report_trajectories(self):
        refused = sum(self._refused.values())
        newly, self._refused_before = refused - self._refused_before, refused
        values = {'taken': self._taken, 'refused': refused}
        values.update({f'refused: {reason}': n for reason, n in self._refused.most_common(10)})
        if newly:
            return WARN, f'{newly} trajectories refused in the last second', values
        return OK, 'joint_trajectory_controller/joint_trajectory', values


def _rows(points, kind, n):
    """Return (k, n) of one kind of the points, None where none has it; ValueError if ragged."""
    rows = [getattr(p, kind) for p in points]
    if not any(len(row) for row in rows):
        return None
    if any(len(row) != n for row in rows):
        raise ValueError(f'{kind} of a point do not belong to {n} joints')
    array_ = np.array(rows, dtype=float)
    if not np.isfinite(array_).all():
        raise ValueError(f'{kind} of a point are not finite')
    return array_


def main(args=None):
    """Run the node; return the exit code."""
    return run_from_command_line('simulator', SimulatorNode, SIMULATOR_PARAMETERS, args)


if __name__ == '__main__':
    sys.exit(main())
