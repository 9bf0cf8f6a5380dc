"""The controller as a process against a small robot and estimator in the test's own process."""

import signal

from control_helpers import PICK
from controller_helpers import (arguments, brakes, JOINTS, listening, MASS, MODEL, phases,
                                plain_model, Robot)
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Inertia, InertiaStamped
import numpy as np
import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, Header
from std_srvs.srv import Trigger

from hand_load_estimator.nodes.qos import LATCHED, OUTPUT


@pytest.fixture(scope='module')
def model_file(tmp_path_factory):
    return plain_model(tmp_path_factory.mktemp('model'))


def test_a_cycle_from_a_late_robot_to_done_and_a_clean_end(listener, start, model_file):
    process = start('controller', *arguments(model_file))
    heard = listening(listener)
    listener.until(lambda: phases(heard) == ['home'], what='the first phase')
    listener.until(lambda: heard.limits, what='the limits before the first move')
    listener.spin(0.5)
    robot = Robot(listener.node)
    robot.order = [3, 1, 0, 2, 5, 4]
    listener.until(lambda: 'carrying' in phases(heard), 'carrying')
    # Also said to whom listens late.
    late = listening(listener)
    listener.until(lambda: late.phase and late.limits and late.collision, 'latched facts')
    listener.until(lambda: 'done' in phases(heard), 'the end of the cycle')
    assert phases(heard) == ['home', 'to_pick', 'at_pick', 'carrying', 'at_place', 'returning',
                             'done']
    assert not robot.refused and not any(m.data for m in heard.collision)
    limits = heard.limits[-1]
    assert list(limits.joint_names) == JOINTS and len(limits.points) == 2
    for point in limits.points:
        assert np.all(np.array(point.accelerations) > 0.0)
        assert np.all(np.array(point.accelerations) <= MODEL.robot.limits.acceleration + 1e-9)
        assert np.all(np.array(point.velocities) <= MODEL.robot.limits.velocity)
    threshold = np.array(heard.thresholds[-1].effort)
    assert threshold.shape == (6,) and np.all(threshold > 0.0)
    assert process.stop(signal.SIGINT) == 0, process.output
    assert 'Traceback' not in process.output


def test_thresholds_come_at_fifty_hertz_while_moving(listener, start, model_file):
    start('controller', *arguments(model_file, speed_scale=0.1))
    heard = listening(listener)
    Robot(listener.node)
    listener.until(lambda: 'to_pick' in phases(heard), 'a motion')
    before = len(heard.thresholds)
    listener.spin(2.0)
    assert phases(heard)[-1] == 'to_pick' and len(heard.thresholds) - before >= 90


def test_collision_stops_reset_goes_on_and_sigterm_brakes(listener, start, model_file):
    process = start('controller', *arguments(model_file, speed_scale=0.15, cycles=0))
    heard = listening(listener)
    robot = Robot(listener.node)
    listener.until(lambda: 'to_pick' in phases(heard), 'a motion')
    listener.spin(0.7)
    robot.arm.push = np.array([0.0, 150.0, 80.0, 0.0, 0.0, 0.0])
    listener.until(lambda: phases(heard)[-1] == 'stopped', 'the stop', 5.0)
    listener.until(lambda: heard.collision[-1].data, 'the collision', 2.0)
    # Topics may overtake one another: the phase can be here before the trajectory.
    listener.until(lambda: brakes(robot.received[-1]), 'the braking trajectory', 2.0)
    listener.spin(1.0)
    assert not np.any(robot.arm.state(robot.now())[1])
    assert np.max(np.abs(robot.arm.state(robot.now())[0] - PICK)) > 0.05
    robot.arm.push = np.zeros(6)
    listener.spin(0.2)
    refused = listener.call(Trigger, 'controller/start', Trigger.Request())
    assert not refused.success and 'collision' in refused.message
    assert listener.call(Trigger, 'controller/reset', Trigger.Request()).success
    listener.until(lambda: phases(heard)[-1] == 'waiting', 'the end of the stop')
    listener.spin(0.5)
    assert not np.any(robot.arm.state(robot.now())[1]), 'a reset moves nothing'
    assert listener.call(Trigger, 'controller/start', Trigger.Request()).success
    listener.until(lambda: phases(heard)[-1] == 'to_pick', 'the motion to go on')
    listener.until(lambda: not heard.collision[-1].data, 'the end of the collision')
    listener.until(lambda: np.max(np.abs(robot.arm.state(robot.now())[1])) > 0.1, 'motion')
    count = len(robot.received)
    process.process.send_signal(signal.SIGTERM)
    listener.until(lambda: any(map(brakes, robot.received[count:])), 'the last trajectory')
    assert process.wait() == 0, process.output
    assert robot.received[-1].points[-1].time_from_start.sec < 2
    listener.spin(2.0)
    assert not np.any(robot.arm.state(robot.now())[1])
    assert np.max(np.abs(robot.arm.state(robot.now())[0] - PICK)) > 0.02


def test_bad_messages_are_counted_and_the_cycle_goes_on_in_a_namespace(listener, start,
                                                                       model_file):
    process = start('controller', *arguments(model_file), '-r', '__ns:=/cell')
    heard = listening(listener, '/cell/')
    node, robot = listener.node, Robot(listener.node, '/cell/')
    states = node.create_publisher(JointState, '/cell/joint_states', OUTPUT)
    covariance = node.create_publisher(Float64MultiArray, '/cell/estimator/load_covariance',
                                       OUTPUT)
    residual = node.create_publisher(JointState, '/cell/estimator/residual_torque', OUTPUT)
    known = node.create_publisher(InertiaStamped, '/cell/estimator/known_load', LATCHED)
    status = node.create_publisher(DiagnosticStatus, '/cell/estimator/status', LATCHED)

    def nonsense():
        for fields in ({'name': JOINTS, 'position': [0.0]}, {'name': []},
                       {'name': JOINTS, 'position': [float('nan')] * 6},
                       {'name': JOINTS[:4], 'position': [0.0] * 4}):
            message = JointState(**fields)
            message.header.stamp = node.get_clock().now().to_msg()
            states.publish(message)
        covariance.publish(Float64MultiArray(data=[1.0, 2.0]))
        known.publish(InertiaStamped(header=Header(frame_id='tool0'),
                                     inertia=Inertia(m=float('nan'))))
        known.publish(InertiaStamped(header=Header(frame_id='tcp'), inertia=Inertia(m=100.0)))
        status.publish(DiagnosticStatus(message='DETERMINED', values=[
            KeyValue(key='tared mass [kg]', value='heavy')]))
        covariance.publish(Float64MultiArray(data=[float('nan')] * 100))
        residual.publish(JointState(name=JOINTS, effort=[float('nan')] * 6))
        residual.publish(JointState(name=JOINTS[:2], effort=[1.0]))

    node.create_timer(0.1, nonsense)
    listener.until(lambda: 'done' in phases(heard), 'the end of the cycle')
    assert not robot.refused and process.process.poll() is None

    def said(concern):
        return {status.name: status for status in heard.diagnostics[-1].status}[
            f'cell/controller: {concern}']

    listener.until(lambda: 'done' in said('motion').message, 'diagnostics of the end')
    rejected = {pair.key: int(pair.value) for pair in said('input').values
                if pair.key.startswith('rejected')}
    for reason in ('short_arrays', 'not_finite', 'missing_joint', 'residual_joints',
                   'residual_not_finite', 'estimate_not_finite', 'known_load_not_finite',
                   'estimate_frame'):
        assert rejected[f'rejected {reason}'] > 0, rejected


def test_missing_residual_torques_are_said(listener, start, model_file):
    start('controller', *arguments(model_file, speed_scale=0.1))
    heard = listening(listener)
    robot = Robot(listener.node)
    listener.until(lambda: 'to_pick' in phases(heard), 'a motion')

    def collision():
        return [(status.level, status.message) for message in heard.diagnostics
                for status in message.status if status.name == 'controller: collision'][-1]

    listener.until(lambda: heard.diagnostics, 'diagnostics')
    listener.until(lambda: collision() == (DiagnosticStatus.OK, 'no collision'),
                   'the word that residuals come')
    robot.residuals = False
    listener.until(lambda: collision()[0] == DiagnosticStatus.WARN, 'the warning', 3.0)
    assert 'no collision would be noticed' in collision()[1]


def test_joint_states_before_the_first_clock_do_not_hold_it_up(listener, start, model_file):
    start('controller', *arguments(model_file, use_sim_time='true'))
    heard, node, robot = listening(listener), listener.node, Robot(listener.node)

    def said(concern):
        return [status.message for message in heard.diagnostics for status in message.status
                if status.name == f'controller: {concern}']

    listener.until(lambda: 'joint states arrive' in ' '.join(said('input')[-1:]), 'input')
    assert 'no /clock arrives' in said('motion')[-1] and not robot.received
    clock = node.create_publisher(Clock, '/clock', OUTPUT)
    node.create_timer(0.01, lambda: clock.publish(Clock(clock=node.get_clock().now().to_msg())))
    listener.until(lambda: 'to_pick' in phases(heard), 'a motion')


def test_what_was_tared_is_still_held(listener, start, model_file):
    start('controller', *arguments(model_file))
    heard, robot = listening(listener), Robot(listener.node)
    robot.tared = True
    listener.until(lambda: 'done' in phases(heard), 'the end of the cycle')
    # The residual torque shows it all the time: counted out, it would be a collision.
    assert not any(m.data for m in heard.collision)
    masses = {float(pair.value) for message in heard.diagnostics for status in message.status
              for pair in status.values if status.name == 'controller: load'
              and status.message == 'the estimate is used' and pair.key == 'mass [kg]'}
    assert masses and all(mass == pytest.approx(MASS) for mass in masses)


@pytest.mark.parametrize('parameters, said', [
    ({'model': '/nowhere.yaml'}, 'neither a path nor a shipped file'),
    ({'home': '[0.0,0.0]'}, '6 joint positions'),
    ({'pick': '[9.0,0.0,0.0,0.0,0.0,0.0]'}, 'outside the joint limits'),
    ({'sigma': 0.0}, 'sigma'), ({'speed_scale': 0.0}, 'speed_scale')])
def test_wrong_parameters_end_with_a_sentence(start, model_file, parameters, said):
    process = start('controller', *arguments(model_file, **parameters))
    assert process.wait() == 2
    assert said in process.output and 'Traceback' not in process.output
