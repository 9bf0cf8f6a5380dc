"""Shared fixtures: a ROS domain of one's own, so that tests and robots never hear each other."""

import os

# One machine only, and before rclpy is imported anywhere.
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ.setdefault('OMP_NUM_THREADS', '1')

import pytest  # noqa: E402
from ros_helpers import Listener, NodeProcess  # noqa: E402

from hand_load_estimator.simulation.own_domain import free_domain


@pytest.fixture
def domain():
    """Yield a domain id no other test on this machine uses meanwhile."""
    with free_domain() as number:
        yield number


@pytest.fixture
def start(domain):
    """Yield start(node, *arguments, **keywords) -> NodeProcess; all are ended after the test."""
    processes = []

    def start_process(node, *arguments, **keywords):
        processes.append(NodeProcess(node, domain, arguments, **keywords))
        return processes[-1]

    yield start_process
    # Asked first: one that is killed leaves its shared memory behind, for the next in its domain.
    for process in processes:
        process.ask()
    for process in processes:
        process.kill(patience=5.0)


@pytest.fixture
def listener(domain, start):
    """
    Yield a Listener on the test's domain; it goes before the nodes it heard.

    After a node was killed Fast DDS 2.14 crashes, once in a hundred times, in the destruction of
    a participant that heard it: the killed one may have held the lock of its shared memory.
    """
    with Listener(domain) as node:
        yield node
