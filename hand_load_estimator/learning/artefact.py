"""
The learned artefact: safetensors and a JSON card, handed over as a folder (E10.1).

It belongs to an arm and an effort kind, never to one torque model.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file, save_file

from ..errors import ConfigurationError
from ..files.output_file import output_folder
from ..files.same_arm import place_difference, places_of
from ..files.whole_file import whole_file
from .features import feature_count, INPUTS
from .interval_factors import LEVELS

SCHEMA = 'hand_load/learned/1'
WEIGHTS, CARD, NETWORK = 'lstm.safetensors', 'card.json', 'lstm'
# What a card's network begins with where it is none, but belongs to the method that follows.
INTERVALS = 'intervals of '
_SHAPES = ('lstm.weight_ih_l0', 'lstm.weight_hh_l0', 'lstm.bias_ih_l0', 'lstm.bias_hh_l0',
           'joint_head.weight', 'joint_head.bias', 'load_head.weight', 'load_head.bias',
           'calibration')


@dataclass(frozen=True)
class Artefact:
    """weights: name -> array; calibration (10, levels): factors of interval_factors; card."""

    weights: dict
    calibration: np.ndarray
    card: dict


def artefact_folder(path, network, inputs=()):
    """
    Return the path of a folder for an artefact of a network, as of output_folder.

    Only one of the same network is replaced: of another some files would stay, without their card.
    """
    folder = output_folder(path, {CARD: SCHEMA}, inputs)
    if (folder / CARD).exists():
        again = 'give another --out'
        card = _read(folder, lambda: json.loads((folder / CARD).read_text(encoding='utf-8')),
                     f'an artefact of {network}, or a new folder', again)
        there = network_of(card) if isinstance(card, dict) else card
        if there != network:
            raise ConfigurationError(folder / CARD, 'is of what another command or network made',
                                     there, network, again)
    return folder


def write_artefact(folder, weights, calibration, card):
    """Write the two files; each appears whole or not at all."""
    write_files(folder, WEIGHTS, {**weights, 'calibration': calibration},
                {**card, 'inputs': list(INPUTS)})


def write_files(folder, name, tensors, card):
    """Write tensors under a file name, and the card; each appears whole or not at all."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    tensors = {key: np.ascontiguousarray(value, dtype=np.float32)
               for key, value in tensors.items()}
    with whole_file(folder / name) as part:
        save_file(tensors, part)
    with whole_file(folder / CARD) as part:
        part.write_text(json.dumps({'schema': SCHEMA, **card}, indent=2) + '\n',
                        encoding='utf-8')


def read_artefact(folder, robot):
    """Return the Artefact of a folder, refused when it belongs to another robot."""
    folder = Path(folder)
    card, tensors = read_files(folder, WEIGHTS, robot, NETWORK)
    if card.get('inputs') != list(INPUTS):
        raise ConfigurationError(
            folder / CARD, 'was trained on other inputs' if 'inputs' in card else
            'does not say what inputs it was trained on', card.get('inputs'),
            'those of learning/features.py', 'train it again')
    _check_tensors(folder, tensors, robot)
    calibration = tensors.pop('calibration').astype(float)
    return Artefact({k: v.astype(float) for k, v in tensors.items()}, calibration, card)


def read_files(folder, name, robot, network, again='make one with `hand_load train`'):
    """
    Return card and tensors of a folder; the card must be the robot's and the network's.

    again: what to do where it is not.
    """
    allowed = f'a folder with {name} and {CARD}'
    card = _read(folder, lambda: json.loads((folder / CARD).read_text(encoding='utf-8')), allowed,
                 again)
    # First: another network's tensors have another name.
    _check_card(folder, card, robot, network, again)
    return card, _read(folder, lambda: load_file(folder / name), allowed, again)


def _read(folder, read, allowed, again):
    try:
        return read()
    except Exception as error:
        raise ConfigurationError(folder, f'is not a learned artefact ({error})', allowed=allowed,
                                 todo=again) from None


def network_of(card):
    """Return which network a card's content tells of; cards without a word are `lstm`."""
    return card.get('network', NETWORK)


def trained_beside_temperatures(card):
    """Tell whether a card's content says so; cards without a word say yes."""
    return card.get('temperatures', True)


def arm_of(robot):
    """Return what a card says of the arm it belongs to."""
    return {'joints': list(robot.joints), 'effort_kind': robot.effort.kind,
            'places': places_of(robot)}


def not_of(card, robot):
    """Return (what, value, allowed) where a card belongs to another arm or effort, else None."""
    if card.get('joints') != list(robot.joints):
        return 'belongs to other joints', card.get('joints'), ', '.join(robot.joints)
    if card.get('effort_kind') != robot.effort.kind:
        return 'belongs to another kind of effort', card.get('effort_kind'), robot.effort.kind
    try:
        apart = place_difference(np.array(card.get('places'), dtype=float).reshape(robot.n, 12),
                                 robot)
    except (TypeError, ValueError):
        return 'does not say where the joints of its arm lie', None, None
    return ('belongs to another arm', apart, robot.name) if apart else None


def _check_card(folder, card, robot, network, again):
    """Refuse a card that is not of this schema, robot and network."""
    if not isinstance(card, dict) or card.get('schema') != SCHEMA:
        raise ConfigurationError(folder / CARD, 'has another schema',
                                 card.get('schema') if isinstance(card, dict) else card, SCHEMA)
    if other := not_of(card, robot):
        raise ConfigurationError(folder / CARD, *other, again)
    if network_of(card) != network:
        raise ConfigurationError(folder / CARD, 'is another network', network_of(card), network,
                                 _goes_with(str(network_of(card))))


def _goes_with(network):
    """Return what to do with an artefact of a network that was not asked for."""
    method = network.removeprefix(INTERVALS)
    return (f'take method {network}' if method == network else
            f'give it as `intervals`, with method {method}')


def _check_tensors(folder, tensors, robot):
    hidden = tensors['lstm.weight_hh_l0'].shape[-1] if 'lstm.weight_hh_l0' in tensors else 0
    n = robot.n
    expected = dict(zip(_SHAPES, (
        (4 * hidden, feature_count(n)), (4 * hidden, hidden), (4 * hidden,), (4 * hidden,),
        (1, hidden), (1,), (20, n * hidden), (20,), (10, len(LEVELS)))))
    for name, shape in expected.items():
        if name not in tensors or tensors[name].shape != shape \
                or not np.isfinite(tensors[name]).all():
            raise ConfigurationError(folder / WEIGHTS, f'has no usable tensor {name}',
                                     tensors[name].shape if name in tensors else 'missing',
                                     f'finite, of shape {shape}', 'train it again')
    if (tensors['calibration'] <= 0.0).any():
        raise ConfigurationError(folder / WEIGHTS, 'has a calibration that is not positive',
                                 tensors['calibration'].tolist(), 'factors above 0',
                                 'train it again')
