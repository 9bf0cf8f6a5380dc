"""Rivals that look at a whole recording at once, behind `--rivals`: how they are fed and asked."""

from dataclasses import dataclass
from importlib import import_module

import numpy as np

from ..errors import ConfigurationError
from ..torque.model_follower import ModelFollower
from .rivals import STANDING

# What is asked of them: after so many seconds of motion, and with the whole run.
OFFLINE_TIMES = {'3 s': 3.0, '10 s': 10.0, 'end': np.inf}
# name: (module here, package it needs, how a user gets that)
RIVALS = {
    'mujoco.sysid': ('rival_mujoco', 'mujoco.sysid', 'pip install "mujoco[sysid]"'),
    'figaroh': ('rival_figaroh', 'figaroh', 'pip install figaroh')}


@dataclass(frozen=True)
class LoadedRun:
    """
    What an offline rival gets of a recording, N samples.

    stamp (N,) [s]; q, v, a (N, n); torque (N, n) [Nm] that the load is to explain: measured less
    the identified model with Coulomb and viscous friction; weight (N, n) [1/Nm]: one over that
    model's error, zero where a joint stands.
    """

    stamp: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    torque: np.ndarray
    weight: np.ndarray

    def until(self, stamp):
        """Return the run up to a stamp [s]."""
        kept = self.stamp <= stamp + 1e-9
        return LoadedRun(*(getattr(self, name)[kept] for name in self.__dataclass_fields__))


def loaded_run(model, samples):
    """Return the LoadedRun of MotionSamples seen through a TorqueModel."""
    follower = ModelFollower(model)
    torque = np.array([follower.update(sample).difference for sample in samples])
    stamp = np.array([sample.stamp for sample in samples])
    q, v, a = (np.array([getattr(sample, name) for sample in samples]) for name in 'qva')
    weight = (np.abs(v) >= STANDING) / model.residuals.rmse
    return LoadedRun(stamp, q, v, a, torque, weight)


def chosen_rivals(names):
    """Return the names of offline rivals; raises ConfigurationError for one that is not there."""
    for name in names:
        if name not in RIVALS:
            raise ConfigurationError('--rivals', 'is not known', name, ', '.join(RIVALS))
        _identify(name)
    return tuple(names)


def _identify(name):
    """Return identify_load of a rival."""
    module, package, way = RIVALS[name]
    try:
        return import_module(f'{__package__}.{module}').identify_load
    except ImportError as error:
        raise ConfigurationError('--rivals', f'{name} needs {package} ({error})', name,
                                 todo=f'{way}, or leave it out') from None


def offline_beliefs(names, robot, model, samples, start):
    """
    Return {rival: {moment: [mean (10,), std (10,)]}}, a sentence in place of a failed one.

    model: the identified TorqueModel with Coulomb and viscous friction; start [s]: motion start.
    """
    if not names or start is None:
        return {}
    run = loaded_run(model, samples)
    out = {}
    for name in names:
        identify, out[name] = _identify(name), {}
        for moment, seconds in OFFLINE_TIMES.items():
            try:
                mean, std = identify(robot, run.until(start + seconds))
                out[name][moment] = [mean.tolist(), std.tolist()]
            except (ValueError, ArithmeticError, np.linalg.LinAlgError, RuntimeError) as error:
                out[name][moment] = f'{type(error).__name__}: {error}'
    return out
