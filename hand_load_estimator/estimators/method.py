"""The protocol every way of estimating follows."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np


@dataclass(frozen=True)
class Belief:
    """What a method believes: mean (10,) and covariance (10, 10) in message order."""

    mean: np.ndarray
    covariance: np.ndarray


class Method(Protocol):
    """One way of estimating the load from MotionSamples and Predictions."""

    name: str
    changes: int
    last_change: float | None
    mismatch: str
    tared: np.ndarray

    def update(self, sample, prediction) -> Belief:
        """Take one MotionSample with its Prediction; return the belief after it."""

    def settle(self):
        """Do what the last sample calls for and its belief need not wait for; safe to repeat."""

    def belief(self) -> Belief:
        """Return the present belief; the prior before any data."""

    def forget(self):
        """Forget the load, keep what is known of the model."""

    def tare(self):
        """Make what is held now the new zero."""
