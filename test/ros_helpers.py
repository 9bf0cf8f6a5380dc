"""Run nodes as processes on a domain of their own and listen to them."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CONTROLLER_YAML = ROOT / 'config' / 'controller.yaml'
# How long what must come may take [s]: tests run beside others on machines as slow as they come.
PATIENCE = 60.0


def node_environment(domain):
    """Return the environment of a node process: this tree, this domain, this machine."""
    return {**os.environ, 'ROS_DOMAIN_ID': str(domain), 'PYTHONPATH': str(ROOT),
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'PYTHONUNBUFFERED': '1'}


class NodeProcess:
    """
    A node as a process; its output is kept in a file.

    node: `simulator`, `estimator`, `controller`, or a path of an executable. group: it has
    processes of its own, which get its signals too, as from a terminal.
    """

    def __init__(self, node, domain, arguments=(), environment=None, group=False):
        self._group = group
        command = [str(node)] if os.sep in str(node) else \
            [sys.executable, '-m', f'hand_load_estimator.nodes.{node}_node']
        self._output = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            [*command, *map(str, arguments)], env=environment or node_environment(domain),
            stdout=self._output, stderr=subprocess.STDOUT, cwd=tempfile.gettempdir(),
            process_group=0 if group else None)

    @property
    def output(self):
        """Everything the process has said so far."""
        self._output.seek(0)
        return self._output.read().decode(errors='replace')

    def stop(self, number=signal.SIGTERM, timeout=15.0):
        """Send a signal; return the exit code."""
        self._send(number)
        return self.wait(timeout)

    def _send(self, number):
        if self._group:
            os.killpg(self.process.pid, number)
        else:
            self.process.send_signal(number)

    def wait(self, timeout=15.0):
        """Return the exit code."""
        try:
            return self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(f'does not end; it said:\n{self.output}') from None

    def ask(self):
        """Ask it to end, and do not wait."""
        if self.process.poll() is None:
            self._send(signal.SIGTERM)

    def kill(self, patience=0.0):
        """End it whatever happens, at the latest in `patience` [s]."""
        try:
            self.process.wait(patience)
        except subprocess.TimeoutExpired:
            self._send(signal.SIGKILL)
            self.process.wait()


class Listener:
    """A node in the test's own process with a context of its own; executor: its class."""

    def __init__(self, domain, executor=None):
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        self.context = Context()
        self.context.init(domain_id=domain)
        # Services nobody calls would cost the listener time at every message.
        self.node = Node('listener', context=self.context, start_parameter_services=False)
        self._executor = (executor or SingleThreadedExecutor)(context=self.context)
        self._executor.add_node(self.node)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()

    def listen(self, kind, topic, qos):
        """Return a list that grows by every message of the topic."""
        heard = []
        self.node.create_subscription(kind, topic, heard.append, qos)
        return heard

    def until(self, condition, what='what was waited for', timeout=PATIENCE):
        """Spin until condition() holds; AssertionError after `timeout` [s]."""
        end = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > end:
                raise AssertionError(f'{what} did not come within {timeout:g} s')
            self._executor.spin_once(timeout_sec=0.05)

    def spin(self, seconds):
        """Spin for some real time [s]."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=max(end - time.monotonic(), 0.0))

    def call(self, kind, service, request, timeout=10.0):
        """Return the response of a service; asked again when no answer comes (all may be)."""
        client = self.node.create_client(kind, service)
        self.until(client.service_is_ready, f'service {service}', timeout)
        # An answer is lost when the server has not discovered the new client yet.
        for patience in (3.0, timeout):
            future = client.call_async(request)
            try:
                self.until(future.done, f'an answer of {service}', patience)
                break
            except AssertionError:
                if patience == timeout:
                    raise
        self.node.destroy_client(client)
        return future.result()
