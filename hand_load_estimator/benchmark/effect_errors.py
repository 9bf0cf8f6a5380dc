"""How far a torque model is off: in torque without load, in mass on loaded runs."""

import numpy as np

from ..estimators.bayes import Bayes
from ..torque.model_follower import ModelFollower
from .contestants import Contestant

MOVING = 0.02            # [rad/s] a joint that stands tells little of its torque
MASS_TIME = 3.0          # [s] after motion start
MASS_MOMENTS = (f'{MASS_TIME:g} s', 'end')


def torque_rmse(model, evidence):
    """Return the RMS (n,) [Nm] of what a TorqueModel leaves of moving joints' torque."""
    motions = [recording.motion for recording in evidence]
    return rms([differences(model, motion) for motion in motions], list(map(moving, motions)))


def moving(motion):
    """Return (N, n) bool: the joints of a Motion that move."""
    return np.abs(motion.v) > MOVING


def rms(left, rows):
    """Return the RMS (n,) [Nm] of what is left (N, n) at rows (N, n) of several recordings."""
    total = sum(np.sum(used * error ** 2, axis=0) for error, used in zip(left, rows))
    return np.sqrt(total / np.maximum(sum(used.sum(axis=0) for used in rows), 1))


def differences(model, motion):
    """Return tau_real - tau_mdl (N, n) along a Motion, as it is followed at run time."""
    follower = ModelFollower(model)
    return np.array([follower.update(sample).difference for sample in motion.samples()])


def mass_errors(model, loaded):
    """
    Return {moment: errors [kg]} of method `bayes` on (Case, CaseRun) pairs.

    Runs in which nothing moves are left out.
    """
    out = {moment: [] for moment in MASS_MOMENTS}
    for case, run in loaded:
        if run.start is None:
            continue
        masses = _masses(model, run.samples, run.start + MASS_TIME)
        for moment, mass in zip(MASS_MOMENTS, masses):
            out[moment].append(mass - case.load.mass)
    return out


def _masses(model, samples, due):
    """Return the mass [kg] believed at a stamp [s] and at the end."""
    contestant = Contestant(model, lambda follower: Bayes(model, follower.uncertainties))
    then = None
    for sample in samples:
        belief = contestant.update(sample)
        if then is None and sample.stamp >= due - 1e-9:
            then = belief.mean[0]
    last = float(belief.mean[0])
    return (last if then is None else float(then)), last
