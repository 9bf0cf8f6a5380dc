"""A direct network as files: weights, calibration and card, belonging to one robot (E10.1)."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from ..errors import ConfigurationError
from .artefact import CARD, read_files, write_files
from .direct_design import Design, SIZES
from .direct_network import build_network
from .fingerprint import fingerprint_of
from .first_moments import LEARNS
from .stated_factors import usable

WEIGHTS = 'network.safetensors'


@dataclass(frozen=True)
class DirectArtefact:
    """network: trained, of its own Design; knots, factors (P, RANGES) of calibrated(); card."""

    network: torch.nn.Module
    knots: np.ndarray
    factors: np.ndarray
    card: dict

    @property
    def fingerprint(self):
        """Numbers that differ where another network was learned or it was calibrated anew."""
        weights = {name: value.numpy() for name, value in self.network.state_dict().items()}
        return fingerprint_of(vars(self.network.design),
                              {**weights, 'knots': self.knots, 'factors': self.factors})


def write_direct_artefact(folder, network, knots, factors, card):
    """Write network and calibration; each file appears whole or not at all."""
    tensors = {f'network.{name}': value.numpy() for name, value in network.state_dict().items()}
    write_files(folder, WEIGHTS, {**tensors, 'knots': knots, 'factors': factors},
                {**card, 'learns': LEARNS})


def read_direct_artefact(folder, robot, network):
    """Return the DirectArtefact of a folder, refused when it is another robot's or network's."""
    folder = Path(folder)
    card, tensors = read_files(folder, WEIGHTS, robot, network)
    if card.get('learns') != LEARNS:
        raise ConfigurationError(folder / CARD, 'is of a network that learnt to answer something '
                                 'else', card.get('learns'), LEARNS, 'train it again')
    try:
        design = _design(card, robot)
        own = build_network(robot, design)
        own.load_state_dict({name[8:]: torch.tensor(value) for name, value in tensors.items()
                             if name.startswith('network.')})
        knots, factors = (tensors[name].astype(float) for name in ('knots', 'factors'))
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        raise ConfigurationError(folder, f'does not hold what its card says ({error})',
                                 todo='train it again') from None
    if not usable(knots, factors, len(design.parameters)) \
            or not all(np.isfinite(value).all() for value in tensors.values()):
        raise ConfigurationError(folder / WEIGHTS, 'has tensors that are not usable',
                                 allowed='finite ones, calibration above 0',
                                 todo='train it again')
    return DirectArtefact(own.train(False), knots, factors, card)


def _design(card, robot):
    content = card['recipe']['design']
    if not set(content['joints']) <= set(robot.joints):
        raise ValueError('it reads joints that the robot does not have')
    design = Design(**{**content, 'joints': tuple(content['joints']),
                       'parameters': tuple(content['parameters'])})
    for name, (least, most) in {**SIZES, 'copies': (2, 1000)}.items():
        if not isinstance(value := getattr(design, name), int) or not least <= value <= most:
            raise ValueError(f'{name} is {value!r}')
    if not 0.0 <= design.thinned < 1.0:
        raise ValueError(f'thinned is {design.thinned!r}')
    return design
