"""Train the network of method `lstm`: seeded, with progress, resumed after a kill."""

import time
from dataclasses import asdict, dataclass

import torch

from .. import seeds
from ..load import MESSAGE_ORDER
from ..model_file import read_model
from .artefact import write_artefact
from .calibration import calibrate, held_out_scores
from .features import feature_count
from .network import LoadNetwork
from .objective import answers, divergence
from .sequences import DURATION
from .shards import make_shard, prior_tensors
from .training_loop import (begin_work, end_work, keep_memory, make_sequences, optimise,
                            pick_device)


@dataclass(frozen=True)
class Recipe:
    """
    Everything that decides the result beside the torque model.

    sequences for training, calibration and validation; passes over the training sequences;
    hidden units; learning_rate at its highest; seed of the first weights and of the order.
    """

    sequences: int = 6400
    calibration: int = 640
    validation: int = 640
    passes: int = 9
    hidden: int = 48
    learning_rate: float = 4e-3
    seed: int = 1


def train(model_path, folder, recipe=Recipe(), device='auto', write=print):
    """
    Train on draws around a torque model file and write the artefact into `folder`.

    Work in progress lies in folder/work and is picked up by the next call with the same recipe
    and model; it is removed at the end. Raises ConfigurationError for a wrong model or device.
    """
    began = time.time()
    keep_memory()
    model, device = read_model(model_path), pick_device(device)
    work = begin_work(folder, model_path, recipe)
    shards = make_sequences(model_path, work, recipe, make_shard, write)
    network = _optimised(model.robot, recipe, shards['training'], work, device, write)
    prior = prior_tensors(model.robot)
    factors = calibrate(network, shards['calibration'], prior)
    scores = held_out_scores(network, factors, shards['validation'], prior)
    weights = {k: v.numpy() for k, v in network.state_dict().items()}
    write_artefact(folder, weights, factors, _card(model, recipe, scores, time.time() - began))
    end_work(work)
    return scores


def _optimised(robot, recipe, paths, work, device, write):
    prior = [t.to(device) for t in prior_tensors(robot)]

    def loss(network, shard, _):
        mean, variance = answers(network, shard, *prior)
        return divergence(mean, variance, shard['load']).mean()

    torch.manual_seed(recipe.seed)
    network = LoadNetwork(feature_count(robot.n), robot.n, recipe.hidden).to(device)
    return optimise(network, recipe, paths, loss, work, write).cpu()


def _card(model, recipe, scores, seconds):
    return {
        'name': f'LSTM load network for {model.robot.name}',
        'joints': list(model.robot.joints), 'effort_kind': model.robot.effort.kind,
        'outputs': 'correction and precision per joint for the recursive regression; shift and '
                   f'spread of {", ".join(MESSAGE_ORDER)}',
        'trained_on': 'draws around the identified torque model; no simulator, no plant',
        'model_recordings': list(model.recordings), 'recipe': asdict(recipe),
        'sequence_seconds': DURATION,
        'seeds': {'training': seeds.TRAINING.start, 'calibration': seeds.CALIBRATION.start,
                  'validation': seeds.VALIDATION.start},
        'torch': torch.__version__, 'wall_seconds': round(seconds), 'held_out': scores}
