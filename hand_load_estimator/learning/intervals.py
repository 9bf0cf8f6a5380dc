"""Intervals of a method that has no network of its own, as files of one arm (E10.1)."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import ConfigurationError
from ..estimators.model_trust import TAILS
from ..torque.misread_weight import GAIN, LEAN, TOOTH_FRICTION
from ..torque.model_file import model_digest
from .artefact import INTERVALS, read_files, write_files
from .stated_factors import ALL, calibrated, LEAST_STD, usable

WEIGHTS = 'intervals.safetensors'
AGAIN = 'make them with `hand_load calibrate`'
_WHAT = {'model': 'torque model', 'function': 'learned torque difference',
         'doubts': 'doubt of what a model cannot state'}


@dataclass(frozen=True)
class Intervals:
    """
    knots, factors (10, RANGES): of stated_factors.calibrated, in message order.

    name: of the folder; origin: origin_of what they were made with, empty where nobody said.
    Draws were judged from the first motion on: from what was known of the mass then to what is
    believed of it before, all factors go over into 1.
    """

    knots: np.ndarray
    factors: np.ndarray
    name: str = ''
    origin: dict = field(default_factory=dict)

    def of(self, std, before):
        """Return factors (..., 10) on std (..., 10); before [kg]: the mass's before any data."""
        std = np.maximum(std, LEAST_STD)
        before = np.log(before)
        way = max(before - self.knots[0, -1], 1e-6)
        known = np.clip((before - np.log(std[..., :1])) / way, 0.0, 1.0)
        return (calibrated(std, ALL, self.knots, self.factors) / std) ** known

    def told(self, origin):
        """Return in words which they are, and what differs where they are used: an origin_of."""
        if not self.origin:
            return f'{self.name}, whose card does not name the torque model they were made with'
        other = [_WHAT[part] for part in origin if self.origin.get(part) != origin[part]]
        return self.name + (f', made with another {" and ".join(other)}' if other else '')


def origin_of(model, method):
    """
    Return {part: digest} of what a Method's deviations follow from.

    TorqueModel, function, and what is doubted beside them.
    """
    function = method.state().get('function')
    return {'model': model_digest(model),
            'function': None if function is None else np.asarray(function).tolist(),
            'doubts': [LEAN, GAIN, TOOTH_FRICTION, TAILS]}


def kind_of(method):
    """Return what a card says it holds that belongs to a method's intervals."""
    return INTERVALS + method


def write_intervals(folder, intervals, card):
    """Write factors and card; each file appears whole or not at all."""
    write_files(folder, WEIGHTS, {'knots': intervals.knots, 'factors': intervals.factors},
                {**card, 'origin': intervals.origin})


def read_intervals(folder, robot, method):
    """Return the Intervals of a folder, refused when they are another robot's or method's."""
    folder = Path(folder)
    card, tensors = read_files(folder, WEIGHTS, robot, kind_of(method), AGAIN)
    both = [tensors[name].astype(float) for name in ('knots', 'factors') if name in tensors]
    if len(tensors) != 2 or len(both) != 2 or not usable(*both, parameters=10):
        raise ConfigurationError(folder / WEIGHTS, 'has tensors that are not usable',
                                 allowed='finite ones, factors above 0', todo=AGAIN)
    origin = card.get('origin')
    return Intervals(*both, folder.resolve().name, origin if isinstance(origin, dict) else {})
