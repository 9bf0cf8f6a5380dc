"""Joint states of a simulated arm as messages, for tests that feed nodes."""

import time
from array import array
from functools import lru_cache

import numpy as np
from sensor_msgs.msg import JointState, Temperature
from std_srvs.srv import Trigger

from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.nodes.stamps import time_message
from hand_load_estimator.plant import Plant
from hand_load_estimator.robot import load_robot
from hand_load_estimator.seeds import SHIPPED_MODEL_PLANT

RATE = 250.0
START = [0.0, -1.2, 1.5, -0.5, -1.0, 0.3]


def arm(rate=RATE):
    """Return the simulated arm the shipped model was identified from, standing."""
    return Plant(load_robot(find_shared('ur10e', 'robots')), seed=SHIPPED_MODEL_PLANT, rate=rate,
                 start_position=START)


def box(mass):
    """Return a load of that mass [kg], 0.1 m before the flange."""
    return LoadParameters(mass, [0.01, 0.02, 0.1], 0.004 * mass * np.eye(3))


@lru_cache(None)
def arm_samples(masses, seconds=4.0, rate=RATE):
    """
    Return [(t, position, velocity, effort)] of the default arm swinging to and fro.

    masses: the loads carried one after the other, for `seconds` each.
    """
    robot = load_robot(find_shared('ur10e', 'robots'))
    plant, start = arm(rate), np.array(START)
    swing = np.array([0.4, 0.5, -0.6, 0.7, 0.8, -0.7])
    times = np.arange(1.0, seconds * len(masses) + 1.0)
    goals = [start + (k % 2 == 0) * swing for k in range(len(times))]
    plant.set_trajectory(list(robot.joints), times, np.array(goals), np.zeros_like(goals))
    samples = []
    for mass in masses:
        plant.attach(box(mass) if mass else None)
        for _ in range(int(seconds * rate)):
            plant.step()
            samples.append((plant.time, *plant.measure()))
    return samples


def standing_samples(mass, seconds):
    """Return [(t, position, velocity, effort)] of the default arm standing with a load."""
    plant = arm()
    plant.attach(box(mass))
    samples = []
    for _ in range(int(seconds * RATE)):
        plant.step()
        samples.append((plant.time, *plant.measure()))
    return samples


def joint_state(names, stamp, position, velocity, effort):
    """Return a JointState; stamp: integer nanoseconds."""
    out = JointState(name=list(names), position=array('d', position),
                     velocity=array('d', velocity), effort=array('d', effort))
    out.header.stamp = time_message(stamp)
    return out


class Feeder:
    """Publishes samples as a driver would, `speed` times as fast."""

    def __init__(self, listener, topic='joint_states', speed=2.0):
        from hand_load_estimator.nodes.qos import OUTPUT
        self._listener, self._speed = listener, speed
        self.joints = load_robot(find_shared('ur10e', 'robots')).joints
        self.publisher = listener.node.create_publisher(JointState, topic, OUTPUT)
        self._temperatures = listener.node.create_publisher(
            Temperature, 'joint_temperatures', OUTPUT)
        self.epoch = time.time_ns()

    def wait(self):
        """Wait until a node listens."""
        self._listener.until(lambda: self.publisher.get_subscription_count() > 0,
                             'a subscription of joint states')
        # The other side may need a moment longer, and drops what comes before.
        self._listener.spin(0.5)

    def temperatures_heard(self):
        """Tell whether a node listens to temperatures."""
        return self._temperatures.get_subscription_count() > 0

    def stamp(self, t):
        """Return the integer nanoseconds of a sample's time."""
        return self.epoch + int(round(t * 1e9))

    def warm(self, celsius=25.0):
        """Publish one temperature of every joint."""
        for joint in self.joints:
            message = Temperature(temperature=celsius)
            message.header.frame_id = joint
            self._temperatures.publish(message)

    def tare(self, samples):
        """Play samples and have what is held tared while they are new; return the answer."""
        for _ in range(5):
            self.play(samples)
            answer = self._listener.call(Trigger, 'estimator/tare', Trigger.Request())
            self.epoch += int(1e9) + self.stamp(samples[-1][0]) - self.stamp(samples[0][0])
            # On a busy machine they may be old before the call is there.
            if 'STALE_INPUT' not in answer.message:
                break
        return answer

    def play(self, samples, change=None):
        """Publish samples in their rhythm; change(k, message) may alter or replace a message."""
        begun, first = time.monotonic(), samples[0][0]
        for k, (t, q, v, effort) in enumerate(samples):
            message = joint_state(self.joints, self.stamp(t), q, v, effort)
            message = change(k, message) if change else message
            if message is not None:
                self.publisher.publish(message)
            ahead = (t - first) / self._speed - (time.monotonic() - begun)
            if ahead > 0.0:
                self._listener.spin(ahead)
