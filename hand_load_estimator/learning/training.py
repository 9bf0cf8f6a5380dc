"""
Train the network of method `lstm`: seeded, with progress, resumed after a kill.

From scratch, or from the weights of an artefact (fine-tuning; without a pass it is calibrated
anew and nothing else).
"""

import time
from dataclasses import dataclass

import torch

from ..load import MESSAGE_ORDER
from ..torque.model_file import read_model
from .artefact import arm_of, write_artefact
from .calibration import calibrate, held_out_scores
from .features import feature_count
from .network import LoadNetwork
from .objective import answers, divergence
from .sequences import DURATION
from .shards import make_shard, prior_tensors
from .start import read_start
from .training_loop import (begin_work, end_work, job_of, keep_memory, make_sequences, optimise,
                            pick_device, spans_of)


@dataclass(frozen=True)
class Recipe:
    """
    Everything that decides the result beside the torque model.

    sequences for training, calibration and validation; passes over the training sequences;
    hidden units; learning_rate at its highest; seed of the first weights and of the order;
    divergence: kind of objective.DIVERGENCES.
    """

    sequences: int = 6400
    calibration: int = 1280
    validation: int = 640
    passes: int = 9
    hidden: int = 48
    learning_rate: float = 4e-3
    seed: int = 1
    divergence: str = 'kl'


# From an artefact's weights, which know the arm already.
FINE_TUNING = Recipe(sequences=1216, calibration=512, validation=256, passes=3,
                     learning_rate=1e-3)


def train(model_path, folder, recipe=Recipe(), device='auto', write=print, start_from=None,
          made_by='train'):
    """
    Train on draws around a torque model file and write the artefact into `folder`.

    start_from: folder of an artefact whose weights are the first ones; its number of hidden units
    holds. With no passes these weights stay and only their calibration is made anew. made_by: the
    command whose artefact this is, which the card tells. Work in progress lies in folder/work and
    is picked up by the next call with the same recipe, model and start; it is removed at the end.
    Raises ConfigurationError for a wrong model, start or device.
    """
    began = time.time()
    keep_memory()
    model, device = read_model(model_path), pick_device(device)
    start = None if start_from is None else read_start(start_from, model.robot)
    recipe = recipe if start is None else start.sized(recipe)
    job, spans = job_of(model_path, model, recipe, start), spans_of(recipe, start)
    work = begin_work(folder, job, spans)
    shards = make_sequences(model_path, work, spans, make_shard, write)
    network = _optimised(model.robot, recipe, shards['training'], work, device, write, start)
    prior = prior_tensors(model.robot)
    factors = calibrate(network, shards['calibration'], prior)
    scores = held_out_scores(network, factors, shards['validation'], prior)
    weights = {k: v.numpy() for k, v in network.state_dict().items()}
    write_artefact(folder, weights, factors,
                   {'made_by': made_by, **_card(model, job, spans, scores, time.time() - began,
                                                _beside_temperatures(model, recipe, start))})
    end_work(work, shards)
    return scores


def _optimised(robot, recipe, paths, work, device, write, start):
    prior = [t.to(device) for t in prior_tensors(robot)]

    def loss(network, shard, _):
        mean, variance, _ = answers(network, shard, *prior)
        return divergence(mean, variance, shard['load'], recipe.divergence).mean()

    torch.manual_seed(recipe.seed)
    network = LoadNetwork(feature_count(robot.n), robot.n, recipe.hidden)
    if start is not None:
        start.put_into(network)
    return optimise(network.to(device), recipe, paths, loss, work, write).cpu()


def _beside_temperatures(model, recipe, start):
    # Weights that no pass has changed know what they knew.
    return start.beside_temperatures if start is not None and not recipe.passes \
        else model.temperatures is not None


def _card(model, job, spans, scores, seconds, beside_temperatures):
    return {
        'name': f'LSTM load network for {model.robot.name}',
        **arm_of(model.robot),
        'outputs': 'correction per joint for the recursive regression; shift and '
                   f'spread of {", ".join(MESSAGE_ORDER)}',
        'trained_on': 'draws around the identified torque model; no simulator, no plant',
        'model_recordings': model.recording_names,
        'temperatures': beside_temperatures, **job, 'sequence_seconds': DURATION,
        'seeds': {name: span.start for name, span in spans.items()},
        'torch': torch.__version__, 'wall_seconds': round(seconds), 'held_out': scores}
