"""
Measure the estimator node: share of messages used, delay from message to estimate, CPU share.

    python test/measure_estimator_node.py --rate 1000 --seconds 20 --method lstm

A process plays a simulated arm's joint states, each stamped when it is sent; this one hears the
estimates. The delay is the time from sending the newest joint state in an estimate to hearing
that estimate, DDS both ways included.
"""

import argparse
import os
import struct
import subprocess
import sys
import time

import numpy as np
from arm_data import Feeder, arm_samples, joint_state
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import InertiaStamped
from rclpy.serialization import serialize_message
from ros_helpers import Listener, NodeProcess, free_domain

from hand_load_estimator.nodes.qos import OUTPUT


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


def measure(rate, seconds, method):
    """Print the figures of one run."""
    delays = []

    def arrived(message):
        stamp = message.header.stamp
        delays.append(time.time_ns() - stamp.sec * 10**9 - stamp.nanosec)

    with free_domain() as domain, Listener(domain) as listener:
        node = NodeProcess('estimator', domain, ['--ros-args', '-p', f'method:={method}'])
        listener.node.create_subscription(InertiaStamped, 'estimator/load', arrived, OUTPUT)
        said = listener.listen(DiagnosticArray, '/diagnostics', OUTPUT)
        listener.until(lambda: said, 60.0, 'diagnostics')
        sender = subprocess.Popen([sys.executable, __file__, '--play', str(domain), '--rate',
                                   str(rate), '--seconds', str(seconds)])
        listener.until(lambda: delays, 60.0, 'an estimate')
        used, begun = cpu_seconds(node.process.pid), time.monotonic()
        listener.spin(seconds - 1.0)
        share = (cpu_seconds(node.process.pid) - used) / (time.monotonic() - begun)
        listener.until(lambda: sender.poll() is not None, 60.0, 'the end of the sender')
        values = {pair.key: pair.value for message in said for status in message.status
                  for pair in status.values}
        node.stop()
    delays = 1e-6 * np.array(delays)
    print(f'{method} at {rate:g} Hz: {values["samples"]} joint states used; {len(delays)} '
          f'estimates, delay median {np.median(delays):.2f} ms, 99th percentile '
          f'{np.percentile(delays, 99):.2f} ms; {100 * share:.0f} % of one core')


def main():
    """Read the command line and measure or play."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--rate', type=float, default=1000.0)
    parser.add_argument('--seconds', type=float, default=20.0)
    parser.add_argument('--method', default='lstm')
    parser.add_argument('--play', type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.play is not None:
        play(args.play, args.rate, args.seconds)
    else:
        measure(args.rate, args.seconds, args.method)


if __name__ == '__main__':
    main()
