"""The simulator node over DDS: topics of a real arm, loads, trajectories, refusals."""

import numpy as np
import pytest
from builtin_interfaces.msg import Duration, Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import InertiaStamped
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, Temperature
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hand_load_estimator.nodes.estimate_messages import vector_of_inertia
from hand_load_estimator.nodes.qos import LATCHED, OUTPUT, measurement

JOINTS = ['shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint', 'wrist_1_joint',
          'wrist_2_joint', 'wrist_3_joint']


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def trajectory(goal, duration, names=JOINTS, stamp=None):
    """Return a move to `goal` (n,) that ends at rest after `duration` [s]."""
    point = JointTrajectoryPoint(positions=[float(q) for q in goal],
                                 velocities=[0.0] * len(goal),
                                 time_from_start=Duration(sec=int(duration)))
    out = JointTrajectory(joint_names=names, points=[point])
    out.header.stamp = stamp or Time()
    return out


@pytest.fixture
def heard(start, listener):
    """Return (process, messages of all topics) of a running simulator."""
    process = start('simulator', '--ros-args', '-p', 'start_temperature:=35.0', '-p',
                    'load.mass:=4.5')
    topics = {'joint_states': listener.listen(JointState, 'joint_states', measurement(2000)),
              'temperatures': listener.listen(Temperature, 'joint_temperatures',
                                              measurement(2000)),
              'clock': listener.listen(Clock, '/clock', measurement(2000)),
              'truth': listener.listen(InertiaStamped, 'simulator/true_load', LATCHED),
              'diagnostics': listener.listen(DiagnosticArray, '/diagnostics', OUTPUT)}
    listener.until(lambda: topics['joint_states'] and topics['truth'], 'a joint state')
    return process, topics


def said(topics, concern):
    """Return the newest (message, values) of a concern."""
    for message in reversed(topics['diagnostics']):
        for status in message.status:
            if status.name == f'simulator: {concern}':
                return status.message, {pair.key: pair.value for pair in status.values}
    return '', {}


def test_publishes_what_an_arm_does(heard, listener):
    process, topics = heard
    # A busy machine slows the simulated clock: so many messages, not so many seconds.
    listener.until(lambda: len(topics['joint_states']) > 750, 'a second and a half')
    states = list(topics['joint_states'])
    assert states[0].name == JOINTS
    assert all(len(m.position) == len(m.velocity) == len(m.effort) == 6 for m in states)
    stamps = np.array([seconds(m.header.stamp) for m in states])
    assert np.allclose(np.diff(stamps), 0.002, atol=1e-6), 'a joint state is missing'
    lift = np.mean([m.effort[1] for m in states[-100:]])
    assert abs(lift) > 30.0, 'an outstretched arm weighs on its shoulder'
    temperatures = topics['temperatures']
    assert {m.header.frame_id for m in temperatures} == set(JOINTS)
    assert all(30.0 < m.temperature < 40.0 for m in temperatures)
    of_one = [seconds(m.header.stamp) for m in temperatures if m.header.frame_id == JOINTS[0]]
    assert np.allclose(np.diff(of_one), 0.1, atol=0.003)
    assert topics['clock'] and abs(seconds(topics['clock'][-1].clock) - stamps[-1]) < 0.05
    assert topics['truth'][-1].header.frame_id == 'tool0'
    assert topics['truth'][-1].inertia.m == 0.0
    assert process.stop() == 0, process.output


def test_load_is_taken_from_parameters_at_the_next_attach(heard, listener):
    _, topics = heard

    def effort():
        topics['joint_states'].clear()
        listener.until(lambda: len(topics['joint_states']) > 250)
        return np.mean([m.effort[1] for m in topics['joint_states']])

    empty = effort()
    assert listener.call(SetBool, 'simulator/attach_load', SetBool.Request(data=True)).success
    listener.until(lambda: topics['truth'][-1].inertia.m > 0.0, 'the truth')
    assert vector_of_inertia(topics['truth'][-1].inertia) == pytest.approx(
        [4.5, 0.02, -0.01, 0.08, 0.02, 0.0, 0.0, 0.02, 0.0, 0.015])
    listener.spin(0.5)
    assert abs(effort() - empty) > 20.0, '4.5 kg at the end of the arm are felt'
    changed = [Parameter('load.mass', value=2.0),
               Parameter('load.com', value=[0.0, 0.0, 0.05])]
    assert listener.call(SetParametersAtomically, 'simulator/set_parameters_atomically',
                         SetParametersAtomically.Request(parameters=[
                             p.to_parameter_msg() for p in changed])).result.successful
    assert topics['truth'][-1].inertia.m == pytest.approx(4.5)
    assert listener.call(SetBool, 'simulator/attach_load', SetBool.Request(data=True)).success
    listener.until(lambda: topics['truth'][-1].inertia.m == 2.0, 'the new truth')
    assert listener.call(SetBool, 'simulator/attach_load', SetBool.Request(data=False)).success
    listener.until(lambda: topics['truth'][-1].inertia.m == 0.0, 'the empty hand')


def test_impossible_load_is_refused_with_a_sentence(heard, listener):
    _, topics = heard
    message = Parameter('load.inertia', value=[1.0, 0.0, 0.0, 0.1, 0.0, 0.1])
    assert listener.call(SetParametersAtomically, 'simulator/set_parameters_atomically',
                         SetParametersAtomically.Request(
                             parameters=[message.to_parameter_msg()])).result.successful
    answer = listener.call(SetBool, 'simulator/attach_load', SetBool.Request(data=True))
    assert not answer.success and 'real body' in answer.message
    assert topics['truth'][-1].inertia.m == 0.0


def test_executes_good_trajectories_and_counts_bad_ones(heard, listener):
    _, topics = heard
    publisher = listener.node.create_publisher(
        JointTrajectory, 'joint_trajectory_controller/joint_trajectory', OUTPUT)
    listener.until(lambda: publisher.get_subscription_count() > 0, 'the subscription')
    goal = [0.1, -0.2, 0.15, -0.1, 0.05, 0.2]
    nan = trajectory(goal, 1)
    nan.points[0].positions[2] = float('nan')
    for bad in (JointTrajectory(joint_names=JOINTS), trajectory(goal[:3], 1),
                trajectory(goal, 1, names=[*JOINTS[:5], 'nose']), nan,
                trajectory(goal, 1, stamp=Time(sec=100)), trajectory([9.0, *goal[1:]], 1)):
        publisher.publish(bad)
    order = [3, 5, 0, 1, 2, 4]
    publisher.publish(trajectory([goal[k] for k in order], 1, [JOINTS[k] for k in order]))
    listener.until(lambda: np.allclose(topics['joint_states'][-1].position, goal, atol=5e-3),
                   'the goal')
    listener.until(lambda: said(topics, 'trajectories')[1].get('taken') == '1', 'one taken')
    values = said(topics, 'trajectories')[1]
    assert values['refused'] == '6', values
    assert any('past' in key for key in values), values
    assert any('shoulder_pan_joint is sent to 9; allowed: -6.28' in key for key in values), values
    levels = [(status.level, status.message) for message in topics['diagnostics']
              for status in message.status if status.name == 'simulator: trajectories']
    # Refused in one second or in two.
    warned = [message for level, message in levels if level == DiagnosticStatus.WARN]
    assert warned and all('refused in the last second' in message for message in warned)
    listener.until(lambda: 'refused' not in said(topics, 'trajectories')[0], 'the end of it')


def test_goes_on_where_time_went_on_after_a_restart(heard, start, listener):
    """A restarted simulator does not turn the clock back under nodes that went on."""
    process, topics = heard
    last = seconds(topics['joint_states'][-1].header.stamp)
    assert process.stop() == 0
    topics['joint_states'].clear()
    start('simulator', '--ros-args', '-p', 'real_time_factor:=0.5')
    listener.until(lambda: topics['joint_states'], 'a joint state after the restart')
    assert seconds(topics['joint_states'][0].header.stamp) > last
    listener.until(lambda: 'real time factor' in said(topics, 'clock')[1]
                   and float(said(topics, 'clock')[1]['real time factor']) < 0.6,
                   'half the pace')
    assert said(topics, 'clock')[0] == 'the clock keeps its pace'


def test_an_arm_that_runs_away_is_told_and_no_longer_published(start, listener, tmp_path):
    """It published infinite positions."""
    effects = tmp_path / 'effects.yaml'
    effects.write_text('effects: [{name: viscous_friction, joints: [wrist_3_joint], '
                       'parameters: {coefficient: 3000}}]\n')
    topics = {'diagnostics': listener.listen(DiagnosticArray, '/diagnostics', OUTPUT),
              'joint_states': listener.listen(JointState, 'joint_states', measurement(5000))}
    process = start('simulator', '--ros-args', '-p', f'hidden_effects:={effects}')
    listener.until(lambda: topics['joint_states'], 'a joint state')
    goal = np.array(topics['joint_states'][-1].position) + 0.3
    commands = listener.node.create_publisher(
        JointTrajectory, 'joint_trajectory_controller/joint_trajectory', OUTPUT)
    listener.until(lambda: commands.get_subscription_count(), 'the simulator as a subscriber')
    commands.publish(trajectory(goal, 1))
    listener.until(lambda: 'runs away' in said(topics, 'clock')[0], 'a sentence')
    listener.spin(0.2)
    published = len(topics['joint_states'])
    assert published and all(np.isfinite(m.position).all() for m in topics['joint_states'])
    commands.publish(trajectory(goal, 1))
    answer = listener.call(SetBool, 'simulator/attach_load', SetBool.Request(data=True))
    assert not answer.success and 'has ended' in answer.message
    listener.until(lambda: 'refused: the simulation has ended' in said(topics, 'trajectories')[1],
                   'the refused trajectory')
    assert len(topics['joint_states']) == published
    assert process.output.count('simulation ended') == 1 and process.process.poll() is None


def test_namespace_moves_all_but_clock_and_diagnostics(start, listener):
    start('simulator', '--ros-args', '-r', '__ns:=/left')
    states = listener.listen(JointState, '/left/joint_states', measurement(100))
    truth = listener.listen(InertiaStamped, '/left/simulator/true_load', LATCHED)
    clock = listener.listen(Clock, '/clock', measurement(100))
    listener.until(lambda: states and truth and clock, 'topics in the namespace')


@pytest.mark.parametrize('parameter, words', [
    ('robot:=nowhere', 'nowhere'), ('hidden_effects:=nowhere.yaml', 'nowhere.yaml'),
    ('rate:=5.0', '30 to 1000')])
def test_wrong_configuration_ends_with_a_sentence(start, parameter, words):
    process = start('simulator', '--ros-args', '-p', parameter)
    assert process.wait(30.0) == 2
    assert words in process.output and 'Traceback' not in process.output
