"""A synthetic arm whose torque holds something its model lacks, and what is learned of it."""

from dataclasses import replace
from functools import lru_cache

from core_helpers import block, exact_model, messages, recording_of
import numpy as np

from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.learning.difference_data import difference_data
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.stream.joint_stream import motion_of

NOTHING = LoadParameters()


def model():
    """Return the model everybody sees through."""
    return exact_model('four')


def lacking(v):
    """Return the torque (..., n) [Nm] that the model lacks: friction bent over velocity."""
    return 0.02 * model().robot.limits.torque * np.tanh(v / 0.1) * np.exp(-np.abs(v) / 0.4)


def stream(load, seconds, seed=0, **options):
    """Return Messages of the arm with its unknown friction."""
    constants = model().robot.effort.torque_constants
    # messages() writes the velocity with its noise; a thousandth more or less bends nothing.
    return [replace(m, effort=m.effort + lacking(m.velocity) / constants)
            for m in messages(model(), load, seconds, seed=seed, **options)]


@lru_cache(None)
def evidence(mass=0.0):
    """Return two recordings as Evidence, with a load of that mass [kg] that is told."""
    out, load = [], block(mass) if mass else NOTHING
    for seed in (1, 2):
        recording = recording_of(stream(load, 12.0, seed), model().robot.joints)
        motion, _ = motion_of(model().robot, recording)
        out.append(prepare(model().robot, f'run {seed}', motion, load))
    return out


@lru_cache(None)
def data(names=('velocity',), mass=0.0):
    """Return DifferenceData of the recordings."""
    return difference_data(model(), evidence(mass), names)


def speeds(count=81, reach=0.8):
    """Return velocities (count, n) [rad/s] that cross standing still."""
    return np.linspace(-reach, reach, count)[:, None] * np.ones(model().robot.n)
