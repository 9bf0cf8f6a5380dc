"""Error of the load estimate before and after, on recordings with a known load."""

from dataclasses import replace

import numpy as np

from ..estimators.bayes import Bayes
from ..joint_stream import JointStream, motion_samples
from ..torque_model import ModelFollower
from .diagnosis import LoadError


def with_load_errors(diagnosis, model, better, runs):
    """
    Return the Diagnosis with the errors of load estimates by the two TorqueModels.

    runs: (Evidence, Recording, LoadParameters); those that carry something count. Method `bayes`,
    which has no learnt part that could hide what the model lacks.
    """
    loaded = [(recording, load) for _, recording, load in runs if load.mass > 0.0]
    if not loaded:
        return replace(diagnosis, load_reason='no test recording with a known load was given')
    return replace(diagnosis, load_before=_error(model, loaded), load_after=_error(better, loaded))


def _error(model, loaded):
    masses, places = [], []
    for recording, load in loaded:
        mean = estimate(model, recording)
        masses.append(mean[0] - load.mass)
        if 'com' in recording.load_known:
            places.append(mean[1:4] - load.com)
    com = np.sqrt(np.mean(np.sum(np.square(places), axis=1))) if places else None
    return LoadError(float(np.sqrt(np.mean(np.square(masses)))), com and float(com), len(masses))


def estimate(model, recording):
    """Return the final estimate (10,) in message order of a Recording."""
    stream, follower = JointStream(model.robot), ModelFollower(model)
    method = Bayes(model, follower.uncertainties)
    for sample in motion_samples(stream, recording):
        if sample.fresh:
            follower.restart()
        else:
            belief = method.update(sample, follower.update(sample))
            follower.carry(belief, method)
    return method.belief().mean
