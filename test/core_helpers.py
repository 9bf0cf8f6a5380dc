"""
A synthetic arm made of the torque model itself, for tests that need to know every truth.

Nothing here comes from plant/: torque is columns @ x + K m + white noise.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from plant_helpers import chain, ur10e

from hand_load_estimator.effects import EffectInput
from hand_load_estimator.estimators.bayes import Bayes
from hand_load_estimator.estimators.build import determined_std
from hand_load_estimator.estimators.pipeline import Pipeline
from hand_load_estimator.estimators.registry import METHODS, with_network
from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.recording import JointSample, Recording, TemperatureSample
from hand_load_estimator.robot import robot_from_content
from hand_load_estimator.torque.columns import (EffectUse, effect_slices, parameter_count,
                                                torque_columns, warmth_of)
from hand_load_estimator.torque.model_follower import ModelFollower
from hand_load_estimator.torque.presliding import PreslidingState
from hand_load_estimator.torque_model import Residuals, TorqueModel

EFFECTS = ('rotor_inertia', 'coulomb_friction', 'viscous_friction', 'presliding_hysteresis',
           'temperature_dependent_viscous_friction', 'torque_offset')
# Values per newton metre of the joint's drive, in the order of each effect's parameters.
VALUES = {'rotor_inertia': (0.004,), 'coulomb_friction': (0.03,), 'viscous_friction': (0.04,),
          'presliding_hysteresis': (0.001,), 'torque_offset': (0.003,),
          'temperature_dependent_viscous_friction': (-6e-4, 4e-6)}
TRAVEL = 1e-3
# Methods with intervals shipped for the shipped model; those of least_squares made it worse.
CALIBRATED = [name for name in METHODS if not with_network(name) and name != 'least_squares']


@dataclass(frozen=True)
class Message:
    """A joint state as drivers send it."""

    stamp: float
    names: tuple
    position: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray


def block(mass, com=(0.02, -0.03, 0.1)):
    """Return a load of that mass [kg] with a full inertia tensor."""
    inertia = mass * np.array([[6e-3, 1e-3, -8e-4], [1e-3, 8e-3, 5e-4], [-8e-4, 5e-4, 5e-3]])
    return LoadParameters(mass, com, inertia)


def four_axes(**content):
    """Return a small arm for 4 kg with other robot-file content where given."""
    return robot_from_content(
        {**chain('z', 'y', 'y', 'x').file.content,
         'rated_load': {'mass': 4.0, 'com': [0.0, 0.0, 0.08]}, **content}, 'four axes')


def effect_uses(robot, names=EFFECTS):
    """Return EffectUses of all joints with a travel that the search's grid holds."""
    uses = []
    for j in range(robot.n):
        for name in names:
            shape = {'presliding_distance': TRAVEL} if name == 'presliding_hysteresis' else {}
            uses.append(EffectUse(name, j, shape))
    return tuple(uses)


def true_parameters(robot, uses):
    """Return x (P,): nominal links and effects in proportion to the drives."""
    x = np.zeros(parameter_count(robot.n, uses))
    x[:10 * robot.n] = robot.nominal_links
    for use, where in effect_slices(robot.n, uses):
        x[where] = np.array(VALUES[use.name]) * robot.limits.torque[use.joint]
    return x


@lru_cache(None)
def exact_model(robot_name='ur10e', names=EFFECTS, rate=100.0, doubt=0.0):
    """
    Return a TorqueModel that is right.

    doubt: relative std of the effects' parameters. Noise of a message is 0.5 % of the drive.
    """
    robot = ur10e(robot_name) if robot_name.startswith('ur10e') else four_axes()
    uses = effect_uses(robot, names)
    mean = true_parameters(robot, uses)
    std = doubt * np.abs(mean)
    std[:10 * robot.n] = 0.0
    noise = message_noise(robot)
    # The filter's two-sided bandwidth makes the RMS of a filtered torque of its density.
    residuals = Residuals(noise * np.sqrt(100.0 * 3.0 / 16.0 / rate), noise ** 2 / rate,
                          np.tile([1e-3, 1e-3, 1e-3], (robot.n, 1)) * noise[:, None])
    return TorqueModel(robot, uses, False, mean, np.diag(std ** 2), residuals,
                       (RecordingMark('made up'),), (15.0, 45.0))


def message_noise(robot):
    """Return the std (n,) [Nm] of one message's torque."""
    return 0.005 * robot.limits.torque


def swing(robot, times, rest=0.6, seed=0, size=0.5):
    """Return q, v, a (N, n): rest, then smooth waves of all joints that grow out of it."""
    rng = np.random.default_rng([seed, 3])
    w = 2.0 * np.pi * rng.uniform(0.15, 0.45, robot.n)
    reach = size * rng.uniform(0.5, 1.0, robot.n) * rng.choice([-1.0, 1.0], robot.n)
    t = np.maximum(times - rest, 0.0)[:, None]
    # 1 - cos starts at rest; a quintic fade keeps its acceleration from jumping.
    u = np.clip(t, 0.0, 1.0)
    fade = u ** 3 * (10 - 15 * u + 6 * u * u), 30 * u ** 2 * (1 - u) ** 2, \
        60 * u * (1 - u) * (1 - 2 * u)
    wave = (reach * (1 - np.cos(w * t)), reach * w * np.sin(w * t),
            reach * w ** 2 * np.cos(w * t))
    q = fade[0] * wave[0]
    v = fade[0] * wave[1] + fade[1] * wave[0]
    a = fade[0] * wave[2] + 2 * fade[1] * wave[1] + fade[2] * wave[0]
    centre = 0.5 * (np.maximum(robot.limits.lower, -2.5) + np.minimum(robot.limits.upper, 2.5))
    return centre + 0.3 + q, v, a


def presliding_path(q, v, dt, distance, plastic=None):
    """Return z and doubt (N, n) along q, v (N, n) of no filter, dt (N,) apart."""
    state = PreslidingState(distance, np.full(len(distance), 2.0) if plastic is None else plastic)
    both = np.array([state.update(*row) for row in zip(q, v, dt)])
    return both[:, 0], both[:, 1]


def torque_of(model, q, v, a, dt, temperature, loads):
    """Return the true torque (N, n) along a motion; loads: (first row, LoadParameters) pairs."""
    robot = model.robot
    z, _ = presliding_path(q, v, np.full(len(q), dt), model.presliding_distance())
    x = EffectInput(q, v, a, warmth_of(robot, np.full(q.shape, temperature)), z)
    columns = torque_columns(robot, model.layout, x)
    torque = columns @ model.mean
    ends = [first for first, _ in loads[1:]] + [len(q)]
    for (first, load), end in zip(loads, ends):
        rows = slice(first, end)
        torque[rows] += robot.load_columns(columns[rows, :, :10 * robot.n]) @ load.to_products()
    return torque


def messages(model, load, seconds=6.0, rate=100.0, seed=0, temperature=25.0, noisy=True,
             change=None, rest=0.6, size=0.5):
    """
    Return Messages of a synthetic arm carrying a load; change: (time [s], load after it).

    temperature [degC] is that of all joints all the time.
    """
    robot, rng = model.robot, np.random.default_rng([seed, 5])
    times = np.arange(int(seconds * rate)) / rate
    q, v, a = swing(robot, times, rest, seed, size)
    loads = [(0, load)] + ([(int(change[0] * rate), change[1])] if change else [])
    torque = torque_of(model, q, v, a, 1.0 / rate, temperature, loads)
    if noisy:
        torque = torque + rng.normal(size=torque.shape) * message_noise(robot)
        v = v + rng.normal(size=v.shape) * 1e-3
    effort = torque / robot.effort.torque_constants
    return [Message(100.0 + t, robot.joints, *row) for t, *row in zip(times, q, v, effort)]


def pipeline_of(model):
    """Return a fresh Pipeline with method bayes."""
    follower = ModelFollower(model)
    return Pipeline(model, follower, Bayes(model, follower.uncertainties),
                    determined_std(model.robot))


def warm(pipeline, celsius=25.0):
    """Tell the pipeline one temperature for all joints."""
    for joint in pipeline.model.robot.joints:
        pipeline.temperature_reading(joint, celsius)
    return pipeline


def feed(pipeline, stream):
    """Feed Messages; return the estimates that came."""
    out = [pipeline.joint_state(m.stamp, m.names, m.position, m.velocity, m.effort)
           for m in stream]
    return [estimate for estimate in out if estimate is not None]


def recording_of(stream, joints, celsius=25.0):
    """Return the Recording of Messages, temperatures before everything else."""
    samples = [TemperatureSample(stream[0].stamp, joint, celsius) for joint in joints]
    samples += [JointSample(m.stamp, m.names, m.position, m.velocity, m.effort) for m in stream]
    return Recording('made up', samples)


def longest_contact(estimates):
    """Return for how long [s] a contact is told without a break."""
    longest, begun = 0.0, None
    for estimate in estimates:
        if 'contact' not in estimate.reason:
            begun = None
            continue
        begun = begun or estimate.stamp
        longest = max(longest, estimate.stamp - begun)
    return longest
