"""Intervals of a method that has no network of its own, as files of one arm (E10.1)."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import ConfigurationError
from .artefact import read_files, write_files
from .stated_factors import usable

WEIGHTS = 'intervals.safetensors'


@dataclass(frozen=True)
class Intervals:
    """knots, factors (10, RANGES): of stated_factors.calibrated, in message order."""

    knots: np.ndarray
    factors: np.ndarray


def kind_of(method):
    """Return what a card says it holds that belongs to a method's intervals."""
    return f'intervals of {method}'


def write_intervals(folder, intervals, card):
    """Write factors and card; each file appears whole or not at all."""
    write_files(folder, WEIGHTS, vars(intervals), card)


def read_intervals(folder, robot, method):
    """Return the Intervals of a folder, refused when they are another robot's or method's."""
    folder = Path(folder)
    _, tensors = read_files(folder, WEIGHTS, robot, kind_of(method))
    if set(tensors) != {'knots', 'factors'} or not usable(
            *(tensors[name].astype(float) for name in ('knots', 'factors')), parameters=10):
        raise ConfigurationError(folder / WEIGHTS, 'has tensors that are not usable',
                                 allowed='finite ones, factors above 0', todo='calibrate again')
    return Intervals(*(tensors[name].astype(float) for name in ('knots', 'factors')))
