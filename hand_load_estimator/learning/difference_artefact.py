"""
A learned function of the no-load torque difference, handed over as a folder (E10.1).

Safetensors and a JSON card. It corrects one torque model, so it belongs to joints, effort kind
and that model; a model identified again wants a function learned again.
"""

from dataclasses import dataclass
import json
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file, save_file

from ..errors import ConfigurationError
from ..estimators.inducing_points import InducingPoints
from ..estimators.network_draws import NetworkDraws
from ..files.whole_file import whole_file
from ..torque.model_file import model_digest
from .difference_inputs import input_width, INPUTS
from .fingerprint import fingerprint_of

SCHEMA = 'hand_load/difference/1'
WEIGHTS, CARD = 'difference.safetensors', 'difference.json'
PREDICTORS = {'gp': InducingPoints, 'neural_process': NetworkDraws, 'distilled': NetworkDraws,
              'bayesian_network': NetworkDraws}
AGAIN = 'make one with `hand_load learn-gp BAG... --model MODEL.yaml --out DIR`'
# Tensors beside those of the predictor, (n,) each.
_SHARED = ('scale', 'gain', 'share', 'left_out_variance')


@dataclass(frozen=True)
class DifferenceArtefact:
    """
    predictor: at(inputs) -> mean, variance; inputs: names; scale (n,) [Nm]: unit of the mean.

    gain, share, left_out_variance (n,): see left_out.LeftOut; card: the JSON content;
    fingerprint: numbers that differ where tensors or inputs do.
    """

    predictor: object
    inputs: tuple
    scale: np.ndarray
    gain: np.ndarray
    share: np.ndarray
    left_out_variance: np.ndarray
    card: dict
    fingerprint: np.ndarray


def write_difference(folder, model, function, names, tensors, told):
    """
    Write the two files; each appears whole or not at all.

    function: a name of PREDICTORS; names: its inputs; tensors of the predictor and the shared
    ones; told: what the card tells besides.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    single = {name: np.ascontiguousarray(value, dtype=np.float32)
              for name, value in tensors.items()}
    # What data took from a prior's variance is a small difference of large numbers.
    single.update({name: np.ascontiguousarray(tensors[name], dtype=np.float64)
                   for name in ('shrink', 'mean_weights') if name in tensors})
    with whole_file(folder / WEIGHTS) as part:
        save_file(single, part)
    card = {'schema': SCHEMA, 'function': function, 'inputs': list(names),
            'joints': list(model.robot.joints), 'effort_kind': model.robot.effort.kind,
            'model': model_digest(model), **told}
    with whole_file(folder / CARD) as part:
        part.write_text(json.dumps(card, indent=2) + '\n', encoding='utf-8')


def read_difference(folder, model):
    """Return the DifferenceArtefact of a folder, refused when it belongs to another model."""
    folder = Path(folder)
    try:
        card = json.loads((folder / CARD).read_text(encoding='utf-8'))
        tensors = load_file(folder / WEIGHTS)
    except Exception as error:
        raise ConfigurationError(folder, f'holds no learned torque difference ({error})',
                                 allowed=f'a folder with {WEIGHTS} and {CARD}',
                                 todo=AGAIN) from None
    _check_card(folder / CARD, card, model)
    tensors = {name: value.astype(float) for name, value in tensors.items()}
    # Artefacts without a word are of a time when the whole mean was subtracted, and judged so.
    tensors.setdefault('gain', np.ones(model.robot.n))
    predictor = PREDICTORS[card['function']]
    sizes = {'n': model.robot.n, 'D': input_width(card['inputs'], model.robot.n), '2': 2}
    shapes = {**predictor.SHAPES, **dict.fromkeys(_SHARED, 'n')}
    for name, shape in shapes.items():
        if name not in tensors or not _fits(tensors[name], shape, sizes):
            raise ConfigurationError(folder / WEIGHTS, f'has no usable tensor {name}',
                                     tensors[name].shape if name in tensors else 'missing',
                                     f'finite, of shape {tuple(shape)} with {sizes}', AGAIN)
    return DifferenceArtefact(predictor(tensors), tuple(card['inputs']),
                              *(tensors[name] for name in _SHARED), card,
                              fingerprint_of([card['function'], card['inputs']], tensors))


def _check_card(path, card, model):
    robot = model.robot
    if not isinstance(card, dict) or card.get('schema') != SCHEMA:
        raise ConfigurationError(path, 'has another schema',
                                 card.get('schema') if isinstance(card, dict) else card, SCHEMA)
    for key, own, what in (
            ('joints', list(robot.joints), 'belongs to other joints'),
            ('effort_kind', robot.effort.kind, 'belongs to another kind of effort'),
            ('model', model_digest(model), 'corrects another torque model')):
        if card.get(key) != own:
            raise ConfigurationError(path, what, card.get(key), own, AGAIN)
    if card.get('function') not in list(PREDICTORS):
        raise ConfigurationError(path, 'names an unknown function', card.get('function'),
                                 ', '.join(PREDICTORS), AGAIN)
    names = card.get('inputs')
    if not isinstance(names, list) or not names \
            or not all(name in list(INPUTS) for name in names):
        raise ConfigurationError(path, 'names unknown inputs', names, ', '.join(INPUTS), AGAIN)


def _fits(tensor, shape, sizes):
    """Tell whether a tensor is finite and has the shape; letters not in sizes are learnt."""
    if tensor.ndim != len(shape) or not np.isfinite(tensor).all():
        return False
    seen = dict(sizes)
    return all(seen.setdefault(letter, size) == size
               for letter, size in zip(shape, tensor.shape))
