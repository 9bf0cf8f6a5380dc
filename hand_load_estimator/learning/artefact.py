"""
The learned artefact: safetensors and a JSON card, handed over as a folder (E10.1).

It belongs to joint names and an effort kind, never to one torque model.
"""

import json
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file, save_file

from ..errors import ConfigurationError
from .features import feature_count
from .interval_factors import LEVELS

SCHEMA = 'hand_load/learned/1'
WEIGHTS, CARD = 'lstm.safetensors', 'card.json'
_SHAPES = ('lstm.weight_ih_l0', 'lstm.weight_hh_l0', 'lstm.bias_ih_l0', 'lstm.bias_hh_l0',
           'joint_head.weight', 'joint_head.bias', 'load_head.weight', 'load_head.bias',
           'calibration')


@dataclass(frozen=True)
class Artefact:
    """weights: name -> array; calibration (10, levels): factors of interval_factors; card."""

    weights: dict
    calibration: np.ndarray
    card: dict


def write_artefact(folder, weights, calibration, card):
    """Write the two files; each appears whole or not at all."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    tensors = {name: np.ascontiguousarray(value, dtype=np.float32)
               for name, value in weights.items()}
    tensors['calibration'] = np.asarray(calibration, dtype=np.float32)
    save_file(tensors, folder / (WEIGHTS + '.part'))
    os.replace(folder / (WEIGHTS + '.part'), folder / WEIGHTS)
    text = json.dumps({'schema': SCHEMA, **card}, indent=2) + '\n'
    (folder / (CARD + '.part')).write_text(text, encoding='utf-8')
    os.replace(folder / (CARD + '.part'), folder / CARD)


def read_artefact(folder, robot):
    """Return the Artefact of a folder, refused when it belongs to another robot."""
    folder = Path(folder)
    try:
        card = json.loads((folder / CARD).read_text(encoding='utf-8'))
        tensors = load_file(folder / WEIGHTS)
    except Exception as error:
        raise ConfigurationError(folder, f'is not a learned artefact ({error})',
                                 allowed=f'a folder with {WEIGHTS} and {CARD}',
                                 todo='make one with `hand_load train`') from None
    _check(folder, card, tensors, robot)
    calibration = tensors.pop('calibration').astype(float)
    return Artefact({k: v.astype(float) for k, v in tensors.items()}, calibration, card)


def _check(folder, card, tensors, robot):
    if not isinstance(card, dict) or card.get('schema') != SCHEMA:
        raise ConfigurationError(folder / CARD, 'has another schema',
                                 card.get('schema') if isinstance(card, dict) else card, SCHEMA)
    if card.get('joints') != list(robot.joints):
        raise ConfigurationError(folder / CARD, 'belongs to other joints', card.get('joints'),
                                 ', '.join(robot.joints), 'train one for this robot')
    if card.get('effort_kind') != robot.effort.kind:
        raise ConfigurationError(folder / CARD, 'belongs to another kind of effort',
                                 card.get('effort_kind'), robot.effort.kind,
                                 'train one for this robot')
    hidden = tensors['lstm.weight_hh_l0'].shape[-1] if 'lstm.weight_hh_l0' in tensors else 0
    n = robot.n
    expected = dict(zip(_SHAPES, (
        (4 * hidden, feature_count(n)), (4 * hidden, hidden), (4 * hidden,), (4 * hidden,),
        (2, hidden), (2,), (20, n * hidden), (20,), (10, len(LEVELS)))))
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
