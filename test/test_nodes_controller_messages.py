"""The controller's messages: mean and covariance are paired, trajectories and limits carried."""

import os
import subprocess
import sys
from types import SimpleNamespace

from control_helpers import covariance_of, load_vector
import numpy as np
import pytest
from ros_helpers import CONTROLLER_YAML, node_environment

from hand_load_estimator.motions.trajectory import Trajectory
from hand_load_estimator.nodes.controller_messages import limits_message, trajectory_message
from hand_load_estimator.nodes.load_pairing import LoadPairing


@pytest.mark.parametrize('simulated, clock', [('false', 'STEADY_TIME'), ('true', 'ROS_TIME')])
def test_a_cycle_is_not_held_up_by_a_wall_clock_that_is_set_back(simulated, clock):
    """No test may set the clock of the machine: the timer is asked which it goes by."""
    code = ('import rclpy, sys\n'
            'from hand_load_estimator.nodes.controller_node import ControllerNode\n'
            'rclpy.init(args=sys.argv)\n'
            'periods = {t.timer_period_ns: t.clock.clock_type.name\n'
            '           for t in ControllerNode().timers}\n'
            'print(periods[min(periods)])')
    done = subprocess.run(
        [sys.executable, '-c', code, '--ros-args', '--params-file', CONTROLLER_YAML,
         '-p', f'use_sim_time:={simulated}'], text=True, capture_output=True, check=True,
        env=node_environment(os.environ.get('ROS_DOMAIN_ID', 1)))
    assert done.stdout.split()[-1] == clock


def test_mean_and_covariance_of_one_estimate_are_paired_in_any_order():
    rng = np.random.default_rng(8)
    estimates = [(k, rng.normal(size=10), covariance_of(0.1 + 0.01 * k)) for k in range(6)]
    for order in range(20):
        pairing, found = LoadPairing(), []
        rng.shuffle(kinds := ['mean', 'variance', 'covariance'])
        for kind in kinds:
            for stamp, mean, covariance in estimates:
                pair = pairing.covariance(covariance) if kind == 'covariance' else getattr(
                    pairing, kind)(stamp, mean if kind == 'mean' else np.diag(covariance))
                found += [pair] if pair else []
        assert found, order
        for mean, covariance in found:
            assert any(mean is m and covariance is c or np.array_equal(mean, m)
                       and np.array_equal(covariance, c) for _, m, c in estimates)


def test_a_covariance_of_another_estimate_is_not_taken():
    pairing = LoadPairing()
    assert pairing.mean((1, 0), load_vector(2.0)) is None
    assert pairing.variance((1, 0), np.diag(covariance_of(0.1))) is None
    assert pairing.covariance(covariance_of(0.1001)) is None
    mean, covariance = pairing.covariance(covariance_of(0.1))
    assert mean[0] == 2.0 and covariance[0, 0] == pytest.approx(0.01)
    assert pairing.unpaired == 1
    assert pairing.covariance(covariance_of(0.1)) is None, 'each mean is used once'


def test_messages_carry_what_they_should():
    trajectory = Trajectory([0.0, 0.5, 1.25], np.arange(6.0).reshape(3, 2),
                            np.ones((3, 2)), np.full((3, 2), 2.0))
    message = trajectory_message(('a', 'b'), trajectory)
    assert list(message.joint_names) == ['a', 'b'] and len(message.points) == 2
    assert list(message.points[1].positions) == [4.0, 5.0]
    assert (message.points[1].time_from_start.sec,
            message.points[1].time_from_start.nanosec) == (1, 250000000)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (0, 0)
    limits = SimpleNamespace(velocity=np.ones(2), acceleration=np.full(2, 3.0),
                             deceleration=np.full(2, 4.0))
    message = limits_message(('a', 'b'), limits, message.header.stamp)
    assert [list(p.accelerations) for p in message.points] == [[3.0, 3.0], [4.0, 4.0]]
