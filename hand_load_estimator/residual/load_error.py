"""Error of the load estimate before and after, on recordings with a known load."""

from dataclasses import replace

import numpy as np

from ..estimators.bayes import Bayes
from ..estimators.build import shipped_artefact
from ..estimators.lstm import Lstm
from ..files.load_file import ASSUMED
from ..learning.artefact import read_artefact
from ..stream.joint_stream import JointStream, motion_samples
from ..torque.model_follower import ModelFollower
from .diagnosis import KeptArtefact, LoadError


def with_load_errors(diagnosis, model, better, runs):
    """
    Return the Diagnosis with the errors of load estimates by the two TorqueModels.

    runs: (Evidence, Recording, LoadParameters); those that carry something known count. Method
    `bayes`, which has no learnt part that could hide what the model lacks.
    """
    before = load_error(model, runs)
    if before is None:
        return replace(diagnosis, load_reason=_no_load_error(runs))
    return replace(diagnosis, load_before=before, load_after=load_error(better, runs))


def with_kept_artefact(diagnosis, model, better, runs):
    """
    Return the Diagnosis with the errors of method `lstm` too, by the artefact shipped for the arm.

    runs: as of with_load_errors. Without one, or without known loads, as it is.
    """
    folder = shipped_artefact(model.robot)
    if folder is None or diagnosis.load_before is None:
        return diagnosis
    artefact = read_artefact(folder, model.robot)
    return replace(diagnosis, kept=KeptArtefact(artefact.card.get('name', folder.name), *(
        load_error(m, runs, artefact) for m in (model, better))))


def known_torque(run):
    """Tell whether the torque of a run's load is known, not only its mass."""
    _, recording, load = run
    return load.mass == 0.0 or 'com' in recording.load_known


def _no_load_error(runs):
    """Return why there is no error of load estimates."""
    assumed = [e.name for e, recording, _ in runs if ASSUMED in recording.load_known]
    return (f'the load of {", ".join(assumed)} is assumed, not known: the model was made with the '
            'same assumption' if assumed else 'no test recording with a known load was given')


def load_error(model, runs, artefact=None):
    """
    Return the LoadError of a TorqueModel over the loaded of the runs, None without any.

    artefact: method `lstm` with that Artefact instead of `bayes`.
    """
    loaded = [(recording, load) for _, recording, load in runs
              if load.mass > 0.0 and ASSUMED not in recording.load_known]
    if not loaded:
        return None
    masses, places, not_asked = [], [], 0
    for recording, load in loaded:
        method = run_through(model, recording, artefact)
        mean = method.belief().mean
        not_asked += artefact is not None and not method.asked
        masses.append(mean[0] - load.mass)
        if 'com' in recording.load_known:
            places.append(mean[1:4] - load.com)
    com = np.sqrt(np.mean(np.sum(np.square(places), axis=1))) if places else None
    return LoadError(float(np.sqrt(np.mean(np.square(masses)))), com and float(com), len(masses),
                     not_asked)


def run_through(model, recording, artefact=None):
    """Return the method, of load_error, at the end of a Recording."""
    stream, follower = JointStream(model.robot), ModelFollower(model)
    method = Bayes(model, follower.uncertainties) if artefact is None else \
        Lstm(model, follower.uncertainties, artefact)
    for sample in motion_samples(stream, recording):
        if sample.fresh:
            follower.restart()
        else:
            belief = method.update(sample, follower.update(sample))
            follower.carry(belief, method)
    return method
