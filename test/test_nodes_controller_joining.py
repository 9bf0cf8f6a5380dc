"""The controller's process joins in: behind remapped topics, and started anew in mid-cycle."""

import signal

from controller_helpers import arguments, listening, phases, plain_model, Robot
import pytest

INPUTS = ('joint_states', 'estimator/load', 'estimator/load_variance', 'estimator/load_covariance',
          'estimator/status', 'estimator/residual_torque', 'estimator/known_load')


@pytest.fixture(scope='module')
def model_file(tmp_path_factory):
    return plain_model(tmp_path_factory.mktemp('model'))


def test_every_topic_may_be_remapped(listener, start, model_file):
    remapped = [part for name in (*INPUTS, 'joint_trajectory_controller/joint_trajectory')
                for part in ('-r', f'{name}:=/cell/{name}')]
    process = start('controller', *arguments(model_file), *remapped)
    heard = listening(listener)
    robot = Robot(listener.node, '/cell/')
    listener.until(lambda: 'done' in phases(heard), 'the end of the cycle')
    assert robot.received and not robot.refused
    assert process.stop(signal.SIGINT) == 0, process.output


def test_one_that_is_started_anew_goes_on_from_where_the_arm_stands(listener, start, model_file):
    first, heard = start('controller', *arguments(model_file)), listening(listener)
    robot = Robot(listener.node)
    listener.until(lambda: 'carrying' in phases(heard), 'carrying')
    assert first.stop(signal.SIGINT) == 0, first.output
    before, again = len(robot.received), listening(listener)
    second = start('controller', *arguments(model_file))
    listener.until(lambda: 'done' in phases(again), 'the end of another cycle')
    assert 'home' in phases(again)
    assert len(robot.received) > before and not robot.refused
    assert not any(message.data for message in again.collision)
    assert second.stop(signal.SIGINT) == 0, second.output
