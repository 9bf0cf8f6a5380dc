"""The protocol every way of estimating follows."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .information import Trust

# A doubt about products is one about place and inertia for loads of this share of the rated mass.
LIGHT = 0.05


@dataclass(frozen=True)
class Belief:
    """What a method believes: mean (10,) and covariance (10, 10) in message order."""

    mean: np.ndarray
    covariance: np.ndarray


def checked(state, shapes):
    """Return {name: array} of a state with exactly these shapes; ValueError says what is not."""
    for name, shape in shapes.items():
        if name not in state:
            raise ValueError(f'{name} is missing')
        if state[name].shape != shape or not np.isfinite(state[name]).all():
            raise ValueError(f'{name} is not finite or not of shape {shape}')
    return {name: np.array(state[name], dtype=float) for name in shapes}


def fitting(state, own):
    """Return {name: array} of a state with names and shapes of another; as of checked."""
    return checked(state, {name: np.shape(value) for name, value in own.items()})


def joined_state(**parts):
    """Return {part.name: array} of the states of parts."""
    return {f'{part}.{name}': value for part, state in parts.items()
            for name, value in state.items()}


def part_of(state, part):
    """Return the state of a part of a joined_state."""
    return {key.partition('.')[2]: value for key, value in state.items()
            if key.startswith(f'{part}.')}


def check_origin(state, name, fingerprint, what):
    """Refuse with a ValueError a state whose entry of that name is not the fingerprint."""
    if not np.array_equal(state.get(name), fingerprint):
        raise ValueError(f'it comes from another {what}')


class Method(Protocol):
    """
    One way of estimating the load from MotionSamples and Predictions.

    counts_doubts: whether what is not known of the model and the tool is in its variances.
    """

    name: str
    changes: int
    last_change: float | None
    mismatch: str
    tared: np.ndarray
    trusted: Trust
    factor: float
    counts_doubts: bool

    def update(self, sample, prediction) -> Belief:
        """Take one MotionSample with its Prediction; return the belief after it."""

    def settle(self):
        """Do what the last sample calls for and its belief need not wait for; safe to repeat."""

    def belief(self) -> Belief:
        """Return the present belief; the prior before any data."""

    def load_as_stated(self):
        """Return products (10,) and covariance (10, 10) as of LoadRegression.load_as_stated."""

    def forget(self):
        """Forget the load, and how well the model foretold its torques."""

    def tare(self):
        """Make what is held now the new zero."""

    def state(self) -> dict:
        """Return {name: array}, all that restore() needs to go on in another process."""

    def restore(self, state):
        """Go on from a state(), as after a gap in the data; ValueError when it does not fit."""
