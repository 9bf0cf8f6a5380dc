"""Signals: a node stops in order when told, also when told twice, and a hanging one ends too."""

import signal
import subprocess
import sys
import time

import pytest
from ros_helpers import node_environment

NODE = """
import time
from rclpy.node import Node
from hand_load_estimator.nodes.runner import run_node

class Stopping(Node):
    def __init__(self):
        super().__init__('stopping')
        print('ready')

    def stop(self):
        print('stopping')
        time.sleep({stopping})
        print('stopped')

raise SystemExit(run_node(Stopping))
"""


@pytest.fixture
def node(domain, request):
    """Return a process that runs a node whose stop() takes so many seconds."""
    process = subprocess.Popen(
        [sys.executable, '-c', NODE.format(stopping=request.param)], stdout=subprocess.PIPE,
        env=node_environment(domain), text=True)
    assert process.stdout.readline() == 'ready\n'
    yield process
    process.kill()
    process.communicate()


@pytest.mark.parametrize('node, signals', [
    (0.5, [signal.SIGINT]), (0.5, [signal.SIGTERM]),
    (0.5, [signal.SIGINT, signal.SIGINT]), (0.5, [signal.SIGINT, signal.SIGTERM])],
    indirect=['node'])
def test_told_once_or_twice_it_stops_in_order(node, signals):
    # As Ctrl-C under `ros2 launch` does it: the terminal tells the node, and launch does.
    for number in signals:
        node.send_signal(number)
        time.sleep(0.1)
    assert node.wait(15.0) == 0
    assert node.stdout.read() == 'stopping\nstopped\n'


@pytest.mark.parametrize('node', [1000.0], indirect=True)
def test_a_second_signal_ends_one_that_hangs(node):
    node.send_signal(signal.SIGINT)
    assert node.stdout.readline() == 'stopping\n'
    time.sleep(1.2)
    node.send_signal(signal.SIGTERM)
    assert node.wait(15.0) == -signal.SIGTERM


@pytest.mark.parametrize('name', ['estimator', 'simulator', 'controller'])
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_it_still_imports_ends_it_in_order(domain, name, number):
    """Python's own handlers made a traceback of it, or the node died of the signal."""
    # What the installed executables do; Python tells of every import when it is done.
    code = f'import sys; from hand_load_estimator.nodes.start import {name}; sys.exit({name}())'
    process = subprocess.Popen([sys.executable, '-X', 'importtime', '-c', code], text=True,
                               env=node_environment(domain), stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)
    try:
        for line in process.stderr:
            if line.split('|')[-1].strip() == 'numpy':
                break
        process.send_signal(number)
        said, imports = process.communicate(timeout=30.0)
        assert process.returncode == 0, imports
        assert 'hand_load_estimator.nodes.runner' in imports, 'the signal came among the imports'
        assert not said and 'Traceback' not in imports
    finally:
        process.kill()
        process.wait()


FAULTY = NODE.replace('raise SystemExit', """
class Faulty(Stopping):
    def __init__(self):
        super().__init__()
        self.create_timer(0.1, self.fail)

    def fail(self):
        raise RuntimeError('a fault of its own')

raise SystemExit""").replace('run_node(Stopping)', 'run_node(Faulty)')


def test_a_fault_of_its_own_still_lets_it_say_its_last_word(domain):
    """The controller's is the braking trajectory."""
    done = subprocess.run([sys.executable, '-c', FAULTY.format(stopping=0.0)], text=True,
                          env=node_environment(domain), capture_output=True, timeout=30.0)
    assert done.returncode == 1 and done.stdout == 'ready\nstopping\nstopped\n'
    assert 'a fault of its own' in done.stderr


def test_without_ros_a_node_ends_with_a_sentence():
    code = ("import sys; sys.modules['rclpy'] = None; "
            'from hand_load_estimator.nodes.start import estimator; sys.exit(estimator())')
    done = subprocess.run([sys.executable, '-c', code], text=True, capture_output=True,
                          env=node_environment(1), timeout=30.0)
    assert done.returncode == 2 and 'Traceback' not in done.stderr
    assert done.stderr.count('\n') == 1 and 'estimator_node needs rclpy' in done.stderr
