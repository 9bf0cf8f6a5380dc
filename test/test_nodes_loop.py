"""All three nodes as processes over DDS: pick, carry and place a load the estimator must find."""

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import InertiaStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory
from ros_helpers import CONTROLLER_YAML

from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import MESSAGE_ORDER
from hand_load_estimator.nodes.estimate_messages import vector_of_inertia
from hand_load_estimator.nodes.qos import LATCHED, OUTPUT
from hand_load_estimator.robot import load_robot

LOAD = [3.5, 0.02, -0.03, 0.12, 0.02, 0.0, 0.0, 0.02, 0.0, 0.01]
TOPICS = {'load': ('estimator/load', InertiaStamped, OUTPUT),
          'variance': ('estimator/load_variance', InertiaStamped, OUTPUT),
          'status': ('estimator/status', DiagnosticStatus, LATCHED),
          'truth': ('simulator/true_load', InertiaStamped, LATCHED),
          'phase': ('controller/phase', String, LATCHED),
          'limits': ('controller/motion_limits', JointTrajectory, LATCHED),
          'thresholds': ('controller/collision_thresholds', JointState, LATCHED),
          'collision': ('controller/collision', Bool, LATCHED),
          'sent': ('joint_trajectory_controller/joint_trajectory', JointTrajectory, OUTPUT)}


class Loop:
    """Three running nodes and what they say; the slowed clock leaves room for a busy machine."""

    def __init__(self, start, listener, method):
        self._listener, self._method, self._start = listener, method, start
        # The simulator last: the others must wait for it and join in.
        self.nodes = {'controller': start('controller', '--ros-args', '--params-file',
                                          CONTROLLER_YAML, '-p', 'use_sim_time:=true', '-p',
                                          'autostart:=true')}
        self.nodes['estimator'] = self.start_estimator()
        self.heard = {name: listener.listen(kind, topic, qos)
                      for name, (topic, kind, qos) in TOPICS.items()}
        self.nodes['simulator'] = start(
            'simulator', '--ros-args', '-p', 'real_time_factor:=0.7', '-p',
            f'load.mass:={LOAD[0]}', '-p', f'load.com:={LOAD[1:4]}', '-p',
            f'load.inertia:={LOAD[4:]}')

    def start_estimator(self):
        """Start an estimator process."""
        return self._start('estimator', '--ros-args', '-p', 'use_sim_time:=true', '-p',
                           f'method:={self._method}')

    def wait_for(self, phase, timeout=60.0):
        """Spin until the controller is in a phase; AssertionError when it stops instead."""
        def there():
            phases = [message.data for message in self.heard['phase']]
            assert 'stopped' not in phases, self.nodes['controller'].output
            return phase in phases
        self._listener.until(there, f'phase {phase}', timeout)

    def hold(self, gripped):
        """Attach or detach the load."""
        assert self._listener.call(SetBool, 'simulator/attach_load',
                                   SetBool.Request(data=gripped)).success

    def error(self):
        """Return mass error and its standard deviation [kg]."""
        variance = {(m.header.stamp.sec, m.header.stamp.nanosec): m.inertia.m
                    for m in self.heard['variance']}
        last = self.heard['load'][-1]
        stamp = (last.header.stamp.sec, last.header.stamp.nanosec)
        self._listener.until(lambda: stamp in variance or variance.update(
            {(m.header.stamp.sec, m.header.stamp.nanosec): m.inertia.m
             for m in self.heard['variance']}), 'the variance')
        return (last.inertia.m - self.heard['truth'][-1].inertia.m, math.sqrt(variance[stamp]))

    def load_id(self):
        """Return how many load changes the estimator has seen."""
        values = {pair.key: pair.value for pair in self.heard['status'][-1].values}
        return int(values['load_id'])


def test_pick_and_place_with_an_unknown_load(start, listener):
    loop = Loop(start, listener, 'lstm')
    loop.wait_for('at_pick')
    assert loop.heard['truth'][-1].inertia.m == 0.0
    error, std = loop.error()
    assert abs(error) < max(0.2, 4.0 * std) and std < 0.3, 'the empty hand weighs nothing'
    values = {pair.key: pair.value for pair in loop.heard['status'][-1].values}
    assert values['method'] == 'lstm', 'no silent fallback to another method'
    assert values['intervals'] == 'calibrated with the network'
    changes = loop.load_id()
    loop.hold(True)
    listener.until(lambda: loop.heard['truth'][-1].inertia.m == LOAD[0], 'the load')
    assert dict(zip(MESSAGE_ORDER, vector_of_inertia(loop.heard['truth'][-1].inertia))) == \
        pytest.approx(dict(zip(MESSAGE_ORDER, LOAD)))
    loop.wait_for('at_place')
    error, std = loop.error()
    assert abs(error) < max(0.15, 4.0 * std) and std < 0.3, (error, std)
    assert loop.load_id() > changes, 'the new load was noticed'
    check_limits(loop)
    carried = loop.load_id()
    loop.hold(False)
    loop.wait_for('done')
    listener.spin(0.5)
    error, std = loop.error()
    # An estimator that only forgot knows nothing, and would be within any standard deviation.
    assert abs(error) < max(0.2, 4.0 * std) and std < 0.3, ('the hand is empty again', error, std)
    assert loop.load_id() > carried, 'that it was emptied was noticed'
    check_restart(loop, listener)
    codes = {name: node.stop() for name, node in loop.nodes.items()}
    assert codes == dict.fromkeys(codes, 0)
    assert not any('Traceback' in node.output for node in loop.nodes.values())


def check_limits(loop):
    """Limits and thresholds are those of the arm, positive and for every joint."""
    robot = load_robot(find_shared('ur10e', 'robots'))
    for message in loop.heard['limits']:
        assert tuple(message.joint_names) == robot.joints and len(message.points) == 2
        for point in message.points:
            accelerations = np.array(point.accelerations)
            assert np.all(accelerations > 0.0)
            assert np.all(accelerations <= robot.limits.acceleration + 1e-9)
            assert np.all(np.array(point.velocities) <= robot.limits.velocity + 1e-9)
    assert loop.heard['limits'] and loop.heard['sent']
    thresholds = loop.heard['thresholds'][-1]
    assert tuple(thresholds.name) == robot.joints and min(thresholds.effort) > 0.0
    assert not any(message.data for message in loop.heard['collision'])
    assert all(message.points for message in loop.heard['sent']), 'never an empty trajectory'


def check_restart(loop, listener):
    """An estimator that is restarted joins in while the others go on."""
    assert loop.nodes['estimator'].stop() == 0
    # What the old one said last may still be on its way.
    listener.spin(0.5)
    loop.heard['status'].clear()
    loop.heard['load'].clear()
    loop.nodes['estimator'] = loop.start_estimator()
    listener.until(lambda: loop.heard['status'] and loop.heard['load']
                   and loop.heard['status'][-1].message not in ('NO_DATA', 'STALE_INPUT'),
                   'the restarted estimator')
    for name in ('simulator', 'controller'):
        assert loop.nodes[name].process.poll() is None, loop.nodes[name].output
