"""The estimator node reloads its torque model, refuses those that do not fit, tells of ageing."""

from copy import copy
from dataclasses import replace
from functools import lru_cache

from arm_data import Feeder
from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger
from test_nodes_estimator import Estimator
from test_same_arm import another_arm, UR10

from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.torque.model_file import write_model

MASS = 3.0


@lru_cache(None)
def arm_samples(seconds=4.0, rub=0.0):
    """Return samples of the arm `exact_model` describes; rub [Nm]: friction of joint 3 beside."""
    out = []
    for m in messages(exact_model(), block(MASS), seconds):
        effort = np.array(m.effort)
        effort[2] += rub * np.sign(m.velocity[2])
        out.append((m.stamp - 100.0, m.position, m.velocity, effort))
    return out


@pytest.fixture
def files(tmp_path):
    """Return the folder of model files: right, friction (wrong), and what does not fit."""
    right = exact_model()
    wrong = right.mean.copy()
    offsets = [where.start for use, where in right.slices() if use.name == 'torque_offset']
    # These do not go with any load. They are found for what they are, and only a mass on the last
    # link is not.
    wrong[offsets[1]] += 20.0
    wrong[offsets[2]] += 12.0
    wrong[10 * (right.robot.n - 1)] -= 1.0
    write_model(tmp_path / 'right.yaml', replace(
        right, recordings=(RecordingMark('run 1', 'ab'), RecordingMark('run 2')),
        diagnosed='2026-03-01T14:30:00+00:00',
        residuals=replace(right.residuals, sliding=0.5 * right.residuals.rmse)))
    write_model(tmp_path / 'wrong.yaml',
                replace(right, mean=wrong, recordings=(RecordingMark('old run'),)))
    write_model(tmp_path / 'joints.yaml', exact_model('four'))
    write_model(tmp_path / 'current.yaml', exact_model('ur10e_current'))
    write_model(tmp_path / 'ur10.yaml', replace(right, robot=another_arm(right.robot, UR10)))
    (tmp_path / 'text.yaml').write_text('schema: something\n')
    (tmp_path / 'broken.yaml').write_text('schema: [1, 2\n')
    (tmp_path / 'date.yaml').write_text('diagnosed: 2024-13-45\n')
    return tmp_path


class Reloading(Estimator):
    """An Estimator whose model is changed while it runs."""

    def __init__(self, start, listener, model):
        super().__init__(start, listener, '-p', f'model:={model}')

    def set_model(self, path):
        """Set the parameter `model`."""
        message = Parameter('model', value=str(path)).to_parameter_msg()
        answer = self._listener.call(SetParameters, 'estimator/set_parameters',
                                     SetParameters.Request(parameters=[message]))
        assert answer.results[0].successful, answer

    def reload(self):
        """Return the answer of ~/reload_model."""
        return self._listener.call(Trigger, 'estimator/reload_model', Trigger.Request())


@pytest.fixture
def estimator(start, listener, files):
    """Return an estimator at work with the wrong model."""
    return Reloading(start, listener, files / 'wrong.yaml')


@pytest.fixture
def feeder(listener, estimator):
    """Return a Feeder somebody listens to."""
    out = Feeder(listener)
    out.wait()
    out.warm()
    return out


def play(feeder, listener, samples):
    """Play samples after those played before."""
    feeder.play(samples)
    feeder.epoch += int(4.5e9)
    listener.spin(0.3)


def test_input_and_load_changes_go_on_with_another_model():
    model = exact_model('four')
    old, new = warm(pipeline_of(model)), pipeline_of(model)
    stream = messages(model, block(1.0), 5.0, change=(3.0, block(3.0)))
    feed(old, [*stream, stream[-1]])
    assert old.load_id > 0 and old.rejected == {'repeated_stamp': 1}
    before = old.load_id
    new.take_over(old)
    assert new.load_id == before and new.samples == 500 and new.rejected == old.rejected
    np.testing.assert_array_equal(new.temperature, np.full(4, 25.0))
    now = new.estimate(stream[-1].stamp)
    assert now.status == 'WAITING_FOR_MOTION' and not now.determined.any()
    assert new.estimate(stream[-1].stamp + 9.0).status == 'STALE_INPUT'
    feed(new, [replace(m, stamp=m.stamp + 6.0) for m in messages(model, block(3.0), 5.0)])
    assert new.load_id == before and abs(new.method.belief().mean[0] - 3.0) < 0.05


def test_limits_of_the_new_model_s_robot_hold_for_what_comes():
    """A limit that was set right counted from the next start only."""
    model = exact_model('four')
    slow = replace(model, robot=copy(model.robot))
    slow.robot.limits = replace(slow.robot.limits, velocity=0.05 * slow.robot.limits.velocity)
    old, new = warm(pipeline_of(slow)), pipeline_of(model)
    feed(old, messages(model, block(1.0), 3.0))
    refused = old.rejected['implausible_velocity']
    assert refused > 20
    new.take_over(old)
    feed(new, [replace(m, stamp=m.stamp + 4.0) for m in messages(model, block(1.0), 3.0)])
    assert new.rejected['implausible_velocity'] == refused


def test_a_better_model_is_taken_without_restart(estimator, feeder, listener, files):
    play(feeder, listener, arm_samples())
    before = estimator.mass()[0]
    assert abs(before - MASS) > 0.3
    listener.until(lambda: estimator.counted('received joint_states') == 400, 'the count')
    load_id = int(estimator.values()['load_id'])
    # A model that does not explain the torques gives no zero.
    refused = feeder.tare(arm_samples())
    assert not refused.success and 'MODEL_MISMATCH' in refused.message
    estimator.set_model(files / 'right.yaml')
    listener.until(lambda: estimator.said('model')[1].get('recordings') == 'old run',
                   'the model at work; setting the parameter alone loads nothing')
    answer = estimator.reload()
    assert answer.success and 'right.yaml' in answer.message
    listener.until(lambda: estimator.status() == 'WAITING_FOR_MOTION'
                   or estimator.status() == 'STALE_INPUT', 'a new start')
    assert estimator.values()['determined'].startswith('0')
    play(feeder, listener, arm_samples())
    mass, std = estimator.mass()
    assert abs(mass - MASS) < max(0.05, 4.0 * std)
    assert int(estimator.values()['load_id']) >= load_id
    listener.until(lambda: estimator.counted('received joint_states') == 1200, 'the count')
    assert int(estimator.said('estimate')[1]['samples']) == 1200
    values = estimator.said('model')[1]
    assert values['file'] == str(files / 'right.yaml') and values['recordings'] == 'run 1, run 2'
    assert values['written'].startswith('20')


def test_a_reload_drops_the_tare_and_says_so(estimator, feeder, listener, files):
    estimator.set_model(files / 'right.yaml')
    assert estimator.reload().success
    assert feeder.tare(arm_samples()).success
    listener.until(lambda: float(estimator.values()['tared mass [kg]']) > 1.0, 'the tare')
    assert 'tare again' in estimator.reload().message
    listener.until(lambda: float(estimator.values()['tared mass [kg]']) == 0.0, 'no tare')


def test_a_model_that_does_not_fit_is_refused(estimator, feeder, listener, files):
    play(feeder, listener, arm_samples())
    estimator.work_off()
    before, determined = estimator.mass(), estimator.values()['determined']
    for name, said in (('joints.yaml', 'another robot'), ('current.yaml', 'motor_current'),
                       ('ur10.yaml', '24 mm from where ur10e'),
                       ('text.yaml', 'schema'), ('broken.yaml', 'not YAML'),
                       ('date.yaml', 'not YAML'),
                       ('nowhere.yaml', 'nowhere'), ('x' * 5000, ''), ('.', '')):
        estimator.set_model(files / name)
        answer = estimator.reload()
        assert not answer.success and said in answer.message, name
        assert 'wrong.yaml stays at work' in answer.message and '\n' not in answer.message
    estimator.set_model('~nobody_of_that_name/model.yaml')
    assert not estimator.reload().success
    listener.spin(0.2)
    assert estimator.mass() == before and estimator.values()['determined'] == determined
    play(feeder, listener, arm_samples())
    listener.until(lambda: int(estimator.said('estimate')[1]['samples']) > 400,
                   'samples taken after the refusals')


def test_an_aged_model_is_told(estimator, feeder, listener, files):
    estimator.set_model(files / 'right.yaml')
    assert estimator.reload().success
    listener.until(lambda: 'too little motion' in estimator.said('model')[0], 'an answer')
    rub = 2.0 * exact_model().residuals.rmse[2]
    fast = Feeder(listener, speed=4.0)
    fast.wait()
    fast.play(arm_samples(28.0, rub))
    estimator.work_off()
    listener.until(lambda: 'aged' in estimator.said('model')[0], 'a warning')
    message, values = estimator.said('model')
    assert message.startswith('model has aged: elbow_joint residual ')
    assert 'times the stated since' in message and 's of motion' in message
    assert 'since the diagnosis of 2026-03-01 14:30 residual of elbow_joint has grown' in message
    assert values['diagnosed'] == '2026-03-01T14:30:00+00:00'
    assert float(values['residual elbow_joint [Nm]']) > 2.0 * float(
        values['residual elbow_joint at the last diagnosis [Nm]'])
    assert float(values['residual ratio elbow_joint']) > 1.5
    assert float(values['motion judged elbow_joint [s]']) > 15.0
    estimator.reload()
    listener.until(lambda: 'too little motion' in estimator.said('model')[0],
                   'a watch that begins anew')
