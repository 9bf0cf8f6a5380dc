"""What an effect of the torque model is: physics, parameters and regressor columns."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class EffectInput:
    """
    What the columns of an effect may depend on, (N, n) each.

    q [rad], v [rad/s], a [rad/s^2]; warmth: joint temperature less the reference [K], 0 where
    it is not measured; z: presliding state in [-1, 1] (presliding.py).
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    warmth: np.ndarray
    z: np.ndarray


@dataclass(frozen=True)
class Shape:
    """A parameter the columns depend on nonlinearly: searched over `grid`, then kept."""

    name: str
    unit: str
    default: float
    grid: tuple


@dataclass(frozen=True)
class Effect:
    """
    One physical effect of a single joint, linear in its parameters.

    parameters: (name, unit) each; prior_std: the same number of fractions of the joint's
    maximum torque, per unit; columns(x, j, shape) -> (N, k) for joint j, where shape maps names
    of `shapes` to values; for an array of m joints and arrays of values, (N, m, k). in_link_torque: whether a sensor behind the gear sees it.
    """

    name: str
    physics: str
    source: str
    parameters: tuple
    prior_std: tuple
    columns: Callable
    shapes: tuple = ()
    in_link_torque: bool = False

    def default_shape(self):
        """Return the mapping of shape names to defaults."""
        return {s.name: s.default for s in self.shapes}
