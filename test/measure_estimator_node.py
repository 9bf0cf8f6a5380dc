"""
Measure the estimator node: share of messages used, delay from message to estimate, CPU share.

    python test/measure_estimator_node.py --rate 1000 --seconds 20 --method lstm

A process plays a simulated arm's joint states, each stamped when it is sent; this one hears the
estimates. The delay is the time from sending the newest joint state in an estimate to hearing
that estimate, DDS both ways included. What of it is not the estimator's is measured in the same
run: a node that only sends stamps back, as many as there are estimates.
"""

import argparse
import gc
import os
import struct
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
from arm_data import Feeder, arm_samples, joint_state
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import InertiaStamped
from rclpy.serialization import serialize_message
from rclpy.node import Node
from ros_helpers import Listener, NodeProcess, node_environment
from sensor_msgs.msg import JointState

from hand_load_estimator.motion import BLOCK
from hand_load_estimator.nodes.draining import subscribe_draining
from hand_load_estimator.nodes.qos import OUTPUT, measurement
from hand_load_estimator.nodes.runner import EventsExecutor, run_node
from hand_load_estimator.simulation.own_domain import free_domain

_LISTEN = 'estimator/load'


def play(domain, rate, seconds):
    """Publish joint states at a steady rate, stamped with the present time."""
    samples = arm_samples((3.0,), seconds, rate)
    with Listener(domain) as listener:
        feeder = Feeder(listener)
        feeder.wait()
        late = 0.0
        # Serialised beforehand: a driver written in C++ takes no processor time to speak of.
        messages = [bytearray(serialize_message(joint_state(feeder.joints, 0, q, v, effort)))
                    for _, q, v, effort in samples]
        begun = time.monotonic()
        for k, message in enumerate(messages):
            ahead = begun + k / rate - time.monotonic()
            if ahead > 0.0:
                time.sleep(ahead)
            late = max(late, -ahead)
            # Four bytes of CDR header, then the stamp.
            struct.pack_into('<iI', message, 4, *divmod(time.time_ns(), 10 ** 9))
            feeder.publisher.publish(bytes(message))
            if k % 200 == 0:
                feeder.warm()
        listener.spin(2.0)
    print(f'sent {len(messages)} joint states at {rate:g} Hz; the sender itself was late by up '
          f'to {1e3 * late:.1f} ms')


def cpu_seconds(pid):
    """Return the processor time a process has used [s]."""
    with open(f'/proc/{pid}/stat', encoding='utf-8') as file:
        fields = file.read().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def stolen_seconds():
    """Return the processor time that the host of a virtual machine has given to others [s]."""
    with open('/proc/stat', encoding='utf-8') as file:
        return int(file.readline().split()[8]) / os.sysconf('SC_CLK_TCK')


@contextmanager
def ended(command, **options):
    """Yield a process that does not outlive the block."""
    process = subprocess.Popen(command, **options)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


class Mirror(Node):
    """Sends stamps back at the estimates' rate and does nothing else."""

    def __init__(self, rate):
        super().__init__('mirror')
        self._each, self._count = max(round(rate * BLOCK), 1), 0
        self._back = self.create_publisher(InertiaStamped, _LISTEN, OUTPUT)
        subscribe_draining(self, JointState, 'joint_states', self._take, measurement(100))

    def _take(self, message):
        self._count += 1
        if self._count % self._each == 0:
            self._back.publish(InertiaStamped(header=message.header))


class Ear(Listener):
    """Hears estimates as quickly as Python can: its own slowness is not the estimator's."""

    def __init__(self, domain):
        super().__init__(domain, EventsExecutor)
        self.delays, self.stolen = [], 0.0
        self.node.create_subscription(InertiaStamped, _LISTEN, self._arrived, OUTPUT)
        gc.collect()
        gc.freeze()

    def _arrived(self, message):
        stamp = message.header.stamp
        self.delays.append(1e-6 * (time.time_ns() - stamp.sec * 10**9 - stamp.nanosec))

    def hear(self, domain, rate, seconds, pid):
        """Play and listen; return the share of a core that process `pid` takes meanwhile."""
        with ended([sys.executable, __file__, '--play', str(domain), '--rate', str(rate),
                    '--seconds', str(seconds)]) as sender:
            self.until(lambda: self.delays, 'an estimate')
            used, stolen, begun = cpu_seconds(pid), stolen_seconds(), time.monotonic()
            self.spin(seconds - 1.0)
            share = (cpu_seconds(pid) - used) / (time.monotonic() - begun)
            self.stolen = stolen_seconds() - stolen
            self.until(lambda: sender.poll() is not None, 'the end of the sender')
        return share

    def told(self):
        """Return the delays in words."""
        return (f'{len(self.delays)} answers, delay median {np.median(self.delays):.2f} ms, '
                f'99th percentile {np.percentile(self.delays, 99):.2f} ms '
                f'(the host took {1e3 * self.stolen:.0f} ms away)')


def measure(rate, seconds, method):
    """Print the figures of one run of the estimator."""
    with free_domain() as domain, Ear(domain) as ear:
        node = NodeProcess('estimator', domain, ['--ros-args', '-p', f'method:={method}'])
        said = ear.listen(DiagnosticArray, '/diagnostics', OUTPUT)
        ear.until(lambda: said, 'diagnostics')
        share = ear.hear(domain, rate, seconds, node.process.pid)
        values = {pair.key: pair.value for message in said for status in message.status
                  for pair in status.values}
        node.stop()
    print(f'{method} at {rate:g} Hz: {values["samples"]} joint states used; {ear.told()}; '
          f'{100 * share:.0f} % of one core', flush=True)


def measure_mirror(rate, seconds):
    """Print the figures of a node that computes nothing."""
    with free_domain() as domain, Ear(domain) as ear:
        with ended([sys.executable, __file__, '--mirror', '--rate', str(rate)],
                   env=node_environment(domain)) as mirror:
            share = ear.hear(domain, rate, seconds, mirror.pid)
    print(f'nothing computed at {rate:g} Hz: {ear.told()}; {100 * share:.0f} % of one core',
          flush=True)


def main():
    """Read the command line and measure or play."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--rate', type=float, default=1000.0)
    parser.add_argument('--seconds', type=float, default=20.0)
    parser.add_argument('--method', default='lstm')
    parser.add_argument('--play', type=int, help=argparse.SUPPRESS)
    parser.add_argument('--mirror', action='store_true', help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.play is not None:
        play(args.play, args.rate, args.seconds)
    elif args.mirror:
        run_node(lambda: Mirror(args.rate))
    else:
        measure_mirror(args.rate, args.seconds)
        measure(args.rate, args.seconds, args.method)


if __name__ == '__main__':
    main()
