"""The estimator node over DDS: topics, statuses, services, bad data, clean exits."""

import math
import signal
import time

import numpy as np
import pytest
from arm_data import Feeder, arm_samples, standing_samples
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import InertiaStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from hand_load_estimator.load import STATUSES
from hand_load_estimator.nodes.estimate_messages import vector_of_inertia
from hand_load_estimator.nodes.qos import LATCHED, OUTPUT, measurement

OUTPUTS = {'load': (InertiaStamped, OUTPUT), 'load_variance': (InertiaStamped, OUTPUT),
           'load_covariance': (Float64MultiArray, OUTPUT), 'status': (DiagnosticStatus, LATCHED),
           'residual_torque': (JointState, measurement(500)), 'markers': (MarkerArray, OUTPUT)}


class Estimator:
    """A running estimator node and all it says."""

    def __init__(self, start, listener, *arguments, prefix='estimator'):
        self._listener = listener
        self.process = start('estimator', '--ros-args', '-p', 'method:=bayes', *arguments)
        self.heard = {name: listener.listen(kind, f'{prefix}/{name}', qos)
                      for name, (kind, qos) in OUTPUTS.items()}
        self.diagnostics = listener.listen(DiagnosticArray, '/diagnostics', OUTPUT)

    def status(self):
        """Return the newest status text, empty before the first."""
        return self.heard['status'][-1].message if self.heard['status'] else ''

    def values(self):
        """Return the newest status values."""
        return {pair.key: pair.value for pair in self.heard['status'][-1].values}

    def mass(self):
        """Return the newest mass and its standard deviation [kg]."""
        return (self.heard['load'][-1].inertia.m,
                math.sqrt(self.heard['load_variance'][-1].inertia.m))

    def said(self, concern, part=''):
        """Return the newest diagnostics (message, values) of a concern that say so."""
        for message in reversed(self.diagnostics):
            for status in message.status:
                if (status.name.endswith(f'estimator: {concern}')
                        and part in status.message):
                    return status.message, {pair.key: pair.value for pair in status.values}
        return '', {}

    def work_off(self):
        """Wait until it has worked off what it was fed: no new load for a second."""
        heard = -1
        while heard < (heard := len(self.heard['load'])):
            self._listener.spin(1.0)

    def counted(self, name):
        """Return a count of the input diagnostics."""
        return int(self.said('input')[1].get(name, 0))

    def stopped(self, number):
        """Return exit code and output after a signal."""
        return self.process.stop(number), self.process.output


@pytest.fixture
def estimator(start, listener):
    """Return a running Estimator."""
    return Estimator(start, listener)


@pytest.fixture
def feeder(listener, estimator):
    """Return a Feeder somebody listens to."""
    out = Feeder(listener)
    out.wait()
    return out


def test_every_topic_keeps_the_contract(estimator, feeder, listener):
    listener.until(lambda: estimator.status() == 'NO_DATA', 'a status before data')
    assert estimator.values()['age'] == 'nan'
    feeder.warm()
    feeder.play(arm_samples((3.0,)))
    estimator.work_off()
    heard = estimator.heard
    for name in OUTPUTS:
        assert heard[name], name
    # The first ones are lost to a topic that is discovered later than the other.
    assert [m.header.stamp for m in heard['load'][-20:]] == [
        m.header.stamp for m in heard['load_variance'][-20:]]
    load, variance = heard['load'][-1], heard['load_variance'][-1]
    assert load.header.frame_id == variance.header.frame_id == 'tool0'
    covariance = np.reshape(heard['load_covariance'][-1].data, (10, 10))
    assert np.allclose(np.diag(covariance), vector_of_inertia(variance.inertia))
    assert np.linalg.eigvalsh(covariance)[0] > -1e-12
    assert list(heard['residual_torque'][-1].name) == list(feeder.joints)
    assert np.isfinite(heard['residual_torque'][-1].effort).all()
    assert {m.id for m in heard['markers'][-1].markers} == {0, 1, 2, 3}
    assert set(estimator.values()) == {'determined', 'age', 'reason', 'load_id', 'method',
                                       'intervals', 'tared mass [kg]', 'tool mass [kg]',
                                       'checkpoint'}
    assert estimator.values()['method'] == 'bayes'
    assert {m.message for m in heard['status']} <= set(STATUSES)
    mass, std = estimator.mass()
    assert abs(mass - 3.0) < max(0.15, 4.0 * std)
    rate = len(heard['load']) / 4.0
    assert 25.0 < rate < 55.0, 'at most 50 Hz, and not much less, of sample time'
    late = listener.listen(DiagnosticStatus, 'estimator/status', LATCHED)
    listener.until(lambda: late, 'the latched status', 0.9)


def test_silence_is_told_and_forgiven(estimator, feeder, listener):
    samples = arm_samples((3.0,))
    feeder.play(samples[:250])
    # A busy node may call its input stale while messages still wait for it.
    listener.until(lambda: estimator.counted('received joint_states') == 250, 'all input')
    listener.until(lambda: estimator.status() == 'STALE_INPUT', 'STALE_INPUT')
    estimator.work_off()
    count = len(estimator.heard['load'])
    listener.spin(0.3)
    assert len(estimator.heard['load']) == count, 'nothing new is published without input'
    listener.until(lambda: 'no joint states' in estimator.said('input')[0], 'a warning')
    feeder.epoch += int(5e9)
    feeder.play(samples[250:750])
    listener.until(lambda: estimator.status() in ('ESTIMATING', 'DETERMINED'), 'an estimate')


def test_every_message_is_used_at_1_khz(estimator, listener):
    samples = arm_samples((2.0,), 3.0, 1000.0)
    feeder = Feeder(listener, speed=1.0)
    feeder.wait()
    feeder.play(samples)
    listener.until(lambda: estimator.said('estimate')[1].get('samples') == str(len(samples)),
                   'the count of every sample')


def test_bad_data_is_counted_by_kind_and_does_no_harm(estimator, feeder, listener):
    """One bad message of every kind among good ones: the node stays and the load comes out."""
    samples = arm_samples((3.0,))

    def spoil(k, message):
        kind, at = divmod(k - 100, 40)
        if at or k < 100:
            return message
        if kind == 0:  # a gripper's own message
            return JointState(header=message.header, name=['finger'], position=[0.1])
        if kind == 1:
            message.name, message.position = message.name[:5], message.position[:5]
            message.velocity, message.effort = message.velocity[:5], message.effort[:5]
        elif kind == 2:
            message.position[3] = math.nan
        elif kind == 3:
            message.effort[1] = math.inf
        elif kind == 4:
            message.effort = message.effort[:2]
        elif kind == 5:
            message.effort = []
        elif kind == 6:
            message.header.stamp = estimator_stamp(k - 1)
        elif kind == 7:
            message.header.stamp = estimator_stamp(k - 20)
        elif kind == 8:
            message.velocity[2] = 1e6
        elif kind == 9:
            message.name = [message.name[0]] * 6
        elif kind == 10:
            return JointState()
        elif kind == 11:  # reordered, with one joint more: good
            order = [3, 0, 5, 1, 4, 2]
            for field in ('position', 'velocity', 'effort'):
                values = getattr(message, field)
                setattr(message, field, [values[j] for j in order] + [0.7])
            message.name = [message.name[j] for j in order] + ['finger']
        return message

    def estimator_stamp(k):
        from hand_load_estimator.nodes.stamps import time_message
        return time_message(feeder.stamp(samples[k][0]))

    feeder.play(samples, spoil)
    listener.until(lambda: int(estimator.said('estimate')[1].get('samples', 0)) > 900)
    listener.spin(1.2)
    rejected = {key.removeprefix('rejected '): int(value) for key, value
                in estimator.said('input')[1].items() if key.startswith('rejected')}
    assert rejected.pop('not_finite') == 2
    assert rejected.pop('short_arrays') == 2
    assert rejected.pop('repeated_stamp') == 1
    assert rejected.pop('backward_stamp') == 1
    assert rejected.pop('implausible_velocity') == 1
    assert sum(rejected.values()) == 2, rejected  # a joint that is missing, one that is twice
    mass, std = estimator.mass()
    assert abs(mass - 3.0) < max(0.2, 4.0 * std)
    assert estimator.stopped(signal.SIGTERM)[0] == 0


def test_temperatures_under_other_names_are_told(estimator, feeder, listener):
    """Ids that match no joint once left the filter without temperatures and the operator calm."""
    names, feeder.joints = feeder.joints, [f'joint_{k}' for k in range(6)]
    listener.until(feeder.temperatures_heard, 'a subscription of temperatures')
    feeder.warm()
    feeder.joints = names

    def said_of_input(told, known):
        """Feed until that is told: a busy node may miss a temperature, or data be told as old."""
        for _ in range(6):
            feeder.play(arm_samples((3.0,)))
            feeder.epoch += int(4e9)
            estimator.work_off()
            message, values = estimator.said('input', told)
            if values.get('temperatures known') == known:
                return message, values
            if known == '6 of 6':
                feeder.warm()
        raise AssertionError(f'{told}, {known}: not told, but {estimator.said("input")}')

    message, values = said_of_input('no temperature of', '0 of 6')
    assert "'joint_5'" in message and 'elbow_joint' in message
    assert values['received temperatures'] == '6'
    feeder.warm()
    said_of_input('joint states arrive', '6 of 6')


def test_torques_that_no_load_makes_are_told_of_a_standing_arm(estimator, feeder):
    """Effort of the wrong sign gave -13 kg with WAITING_FOR_MOTION, and diagnostics said OK."""
    samples = standing_samples(3.0, 6.0)
    feeder.epoch = time.time_ns()
    feeder.play([(t, q, v, -effort) for t, q, v, effort in samples])
    estimator.work_off()
    told = [status for message in estimator.diagnostics for status in message.status
            if status.name.endswith('estimator: estimate')
            and status.message.startswith('WAITING_FOR_MOTION')]
    assert told and all(status.level == DiagnosticStatus.WARN for status in told[-2:])
    assert 'run hand_load check' in told[-1].message and estimator.mass()[0] < -1.0


def test_a_real_arm_is_told_that_the_shipped_model_is_a_simulated_ones(estimator, listener):
    listener.until(lambda: 'identify your own' in estimator.said('model')[0], 'a warning')
    assert 'identify your own' in estimator.process.output


def test_gap_and_restarted_clock_are_survived(estimator, feeder, listener):
    samples = arm_samples((3.0,))
    feeder.play(samples[:300])
    feeder.play(samples[500:700])
    feeder.epoch -= int(60e9)
    feeder.play(samples[700:])
    listener.until(lambda: estimator.counted('rejected clock_restart') == 1
                   and estimator.counted('rejected gap') >= 1, 'the counts')
    listener.until(lambda: estimator.heard['load'][-1].header.stamp.sec
                   <= feeder.epoch // 10**9 + 5, 'estimates of the new time')
    assert estimator.process.process.poll() is None


def test_another_arms_joint_states_are_told_with_both_names(estimator, feeder, listener):
    """`no joint states yet` was said of 500 a second."""
    def renamed(_, message):
        message.name = [f'lwr_{k}_joint' for k in range(6)]
        return message

    told = 'joint states name lwr_0_joint, '
    feeder.play(arm_samples((3.0,))[:250], renamed)
    listener.until(lambda: estimator.values()['reason'].startswith(told), 'the reason')
    assert estimator.status() == 'NO_DATA'
    assert f'but none of {", ".join(feeder.joints)}' in estimator.values()['reason']
    listener.until(lambda: estimator.counted('joint_states of no joint of this robot') == 250,
                   'the count')


def test_reset_forgets_and_tare_makes_zero(estimator, feeder, listener):
    samples = arm_samples((3.0,))
    known = listener.listen(InertiaStamped, 'estimator/known_load', LATCHED)
    listener.until(lambda: known, 'what is held beside the estimate')
    assert known[-1].inertia.m == 0.0
    early = listener.call(Trigger, 'estimator/tare', Trigger.Request())
    assert not early.success and 'NO_DATA' in early.message
    assert feeder.tare(samples).success
    listener.until(lambda: known[-1].inertia.m > 2.5, 'what was tared')
    before = known[-1].inertia.m
    assert known[-1].inertia.com.z == pytest.approx(vector_of_inertia(
        known[-1].inertia)[3]) and known[-1].header.frame_id == 'tool0'
    feeder.play(samples)
    estimator.work_off()
    assert abs(estimator.mass()[0]) < 0.3
    assert float(estimator.values()['tared mass [kg]']) == pytest.approx(before, abs=0.1)
    listener.until(lambda: estimator.values()['determined'].startswith('1'), 'a found mass')
    answer = listener.call(Trigger, 'estimator/reset', Trigger.Request())
    assert answer.success and answer.message.startswith('the load is forgotten; the tare of ')
    assert '~/reload_model drops it' in answer.message
    listener.until(lambda: estimator.values()['determined'].startswith('0'),
                   'an estimate that knows nothing')


def test_silence_is_told_by_what_arrives_whatever_the_clocks_say(estimator, feeder, listener):
    # A driver whose clock is half a minute ahead of the estimator's.
    feeder.epoch += int(30e9)
    feeder.play(arm_samples((3.0,)))
    assert estimator.status() in ('ESTIMATING', 'DETERMINED')
    listener.until(lambda: estimator.status() == 'STALE_INPUT', 'STALE_INPUT')


def test_refused_joint_states_are_no_input(estimator, feeder, listener):
    feeder.play(arm_samples((3.0,))[:300])

    def broken(_, message):
        message.effort = []
        return message

    for _ in range(3):
        feeder.play(arm_samples((3.0,))[300:500], broken)
    assert estimator.status() == 'STALE_INPUT'


def test_namespace_and_remapping(start, listener):
    estimator = Estimator(start, listener, '-r', '__ns:=/left', '-r',
                          'joint_states:=/robot/joint_states', prefix='/left/estimator')
    feeder = Feeder(listener, '/robot/joint_states')
    feeder.wait()
    feeder.play(arm_samples((3.0,))[:400])
    listener.until(lambda: estimator.heard['load'], 'a load in the namespace')
    listener.until(lambda: estimator.said('input')[1], 'diagnostics')
    names = {status.name for message in estimator.diagnostics for status in message.status}
    assert 'left/estimator: input' in names


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_ends_cleanly_on_a_signal(estimator, listener, number):
    listener.until(lambda: estimator.status(), 'a status')
    code, output = estimator.stopped(number)
    assert code == 0 and 'Traceback' not in output, output


def test_status_keeps_up_with_a_simulation_faster_than_time(listener, estimator):
    """As often in simulated time as else: whoever goes by that clock knows no other."""
    feeder = Feeder(listener, speed=8.0)
    feeder.wait()
    before = len(estimator.heard['status'])
    feeder.play(arm_samples((3.0,))[:750])
    listener.until(lambda: estimator.counted('received joint_states') == 750, 'all input')
    # By the clock on the wall there would be four.
    assert len(estimator.heard['status']) - before > 0.5 * 3.0 / 0.1
