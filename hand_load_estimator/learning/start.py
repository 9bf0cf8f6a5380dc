"""What a fine-tuning starts from: the weights of an artefact, and how its card names them."""

from dataclasses import dataclass, replace
import hashlib
from pathlib import Path

import torch

from .artefact import read_artefact, trained_beside_temperatures, WEIGHTS


@dataclass(frozen=True)
class Start:
    """
    weights: name -> array, as of an Artefact; note: name and sha256 of the weights' file.

    beside_temperatures: whether they were trained so.
    """

    weights: dict
    note: dict
    beside_temperatures: bool

    def sized(self, recipe):
        """Return a Recipe with the hidden units these weights have: they cannot be changed."""
        return replace(recipe, hidden=self.weights['lstm.weight_hh_l0'].shape[-1])

    def put_into(self, network):
        """Give a LoadNetwork these weights."""
        network.load_state_dict({name: torch.tensor(value, dtype=torch.float32)
                                 for name, value in self.weights.items()})


def read_start(folder, robot):
    """Return the Start of an artefact's folder; raises ConfigurationError for another robot's."""
    artefact = read_artefact(folder, robot)
    return Start(artefact.weights, {'name': artefact.card.get('name', ''),
                                    'sha256': sha256_of(Path(folder) / WEIGHTS)},
                 trained_beside_temperatures(artefact.card))


def sha256_of(path):
    """Return what `sha256sum` says of a file."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
