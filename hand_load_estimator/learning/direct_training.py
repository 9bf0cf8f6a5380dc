"""
Train a direct network (E1.3 to E1.6, E6.1, E6.2) on the same draws as the default method's.

Every step takes pieces of the motions and torque errors of a shard with freshly drawn loads: what
a load does to the torque is linear in it, so one motion teaches many. Pieces are short at first,
because what a pose and a torque say of a load is learnt from many poses, not from long ones; then
they grow until the network has learnt to gather what a whole sequence says.
"""

import time
from dataclasses import dataclass

import numpy as np
import torch

from ..torque.model_file import read_model
from .artefact import arm_of
from .direct_artefact import write_direct_artefact
from .direct_calibration import direct_answers, inputs_of_shard
from .direct_design import NETWORKS, Design
from .direct_network import build_network
from .direct_shards import make_direct_shard
from .first_moments import LABEL_STD, moments_of
from .objective import DIVERGENCES
from .random_loads import random_load
from .sequences import DURATION
from .stated_intervals import calibrate_stated, judged_samples, scores_of
from .training_loop import (begin_work, end_work, job_of, keep_memory, make_sequences, optimise,
                            pick_device, spans_of)

# Samples of a piece, and the share of the training by which pieces are so long; about SAMPLES per
# step whatever their length.
PIECES = ((10, 0.4), (50, 0.65), (200, 0.85), (500, 1.0))
SAMPLES = 4800
# Loads drawn once for all steps: drawing them anew takes as long as the network's own step.
LOADS = 8192


@dataclass(frozen=True)
class DirectRecipe:
    """As training.Recipe, for a Design; fewer sequences, as each serves many loads."""

    design: Design
    sequences: int = 2048
    calibration: int = 256
    validation: int = 128
    passes: int = 120
    learning_rate: float = 3e-3
    seed: int = 1
    divergence: str = 'kl'


def train_direct(model_path, folder, recipe, device='auto', write=print):
    """Train on draws around a torque model file; as training.train."""
    began = time.time()
    keep_memory()
    model, device = read_model(model_path), pick_device(device)
    robot = model.robot
    job, spans = job_of(model_path, model, recipe), spans_of(recipe)
    work = begin_work(folder, job, spans)
    shards = make_sequences(model_path, work, spans, make_direct_shard, write)
    torch.manual_seed(recipe.seed)
    network = optimise(build_network(robot, recipe.design).to(device), recipe,
                       shards['training'], Loss(robot, recipe, len(shards['training'])), work,
                       write).cpu().train(False)
    picked = recipe.design.picked
    knots, factors = calibrate_stated(
        direct_answers(network, robot, shards['calibration']), picked)
    scores = scores_of(direct_answers(network, robot, shards['validation']), picked, knots,
                       factors)
    write_direct_artefact(folder, network, knots, factors,
                          _card(model, recipe.design, job, spans, scores, device,
                                time.time() - began))
    end_work(work, shards)
    return scores


class Loss:
    """
    The divergence between labels and answers (E6.1), averaged over judged times.

    Each is followed by the deviation stated with it, held fixed (Seitzer et al. 2022, beta = 0.5):
    else what is known well drowns what is not known yet, which then never is.

    shards: their number, which with the passes tells how far a training is.
    """

    def __init__(self, robot, recipe, shards):
        self._robot, self._seed, self._kind = robot, recipe.seed, recipe.divergence
        self._design, self._steps = recipe.design, recipe.passes * shards
        self._joints = [robot.joints.index(name) for name in recipe.design.joints]
        rng = np.random.default_rng([recipe.seed, 2])
        self._loads = np.array([random_load(rng, robot).to_message() for _ in range(LOADS)])
        self._peak = torch.tensor(robot.limits.torque[self._joints], dtype=torch.float32)

    def __call__(self, network, shard, step):
        """Return the loss of a network on a shard with the loads of this step."""
        rng = np.random.default_rng([self._seed, 1, step])
        shard = self.pieces(rng, shard, step)
        pieces, steps = shard['error'].shape[:2]
        load = self._loads[rng.integers(LOADS, size=pieces)]
        x = inputs_of_shard(self._robot, self._joints, shard, load)
        load = moments_of(torch.tensor(load, device=x.device, dtype=x.dtype))
        at = torch.tensor(judged_samples(steps))
        if self._design.network == 'two_network':
            return self._of_two(network, x, load, shard['error'], at)
        masks = network.masks(len(x), torch.Generator().manual_seed(step))
        mean, std, _ = network(x, at=at, masks=masks)
        # Thinned networks are points: their scatter, not their head, tells how sure they are.
        return self._divergence(mean, network.scale.expand_as(std) if masks is not None else std,
                                load, network.scale)

    def pieces(self, rng, shard, step):
        """
        Return a shard of random pieces.

        Of those long enough to hold the start of a motion half begin where the sequence does; a
        change of load restarts the network anywhere.
        """
        count, whole = shard['error'].shape[:2]
        length = next(size for size, share in PIECES if step < share * self._steps)
        length, pieces = min(length, whole), max(SAMPLES // length, 1)
        which = torch.tensor(rng.integers(count, size=pieces))
        first = rng.integers(whole - length + 1, size=pieces)
        if length > PIECES[1][0]:
            first[rng.random(pieces) < 0.5] = 0
        rows = torch.tensor(first)[:, None] + torch.arange(length)
        return {'motion': shard['motion'][:, which[:, None], rows],
                **{name: shard[name][which[:, None], rows]
                   for name in ('warmth', 'columns', 'error')}}

    def _divergence(self, mean, std, load, scale):
        width = torch.tensor(LABEL_STD, dtype=mean.dtype, device=mean.device)
        each = DIVERGENCES[self._kind](mean, std ** 2, load[:, None], width)
        weighed = (std / scale).detach() * each
        # What is told stays the divergence; only what is followed is weighed.
        return (weighed + (each - weighed).detach())[..., self._design.learnt].mean()

    def _of_two(self, network, x, load, error, at):
        first, predicted, corrected, _ = network.passes(x)
        of_load = sum(self._divergence(mean[:, at], std[:, at], load, network.load.scale)
                      for mean, std in (first, corrected))
        label = error[..., self._joints] / self._peak.to(x.device)
        return of_load + network.error_loss(predicted, label)


def _card(model, design, job, spans, scores, device, seconds):
    return {
        'name': f'{NETWORKS[design.network]} for {model.robot.name}',
        **arm_of(model.robot),
        'network': design.network,
        'outputs': f'mean and standard deviation of {", ".join(design.parameters)}',
        'trained_on': 'draws around the identified torque model; no simulator, no plant',
        'model_recordings': model.recording_names, **job, 'sequence_seconds': DURATION,
        'seeds': {name: span.start for name, span in spans.items()},
        'torch': torch.__version__, 'device': device.type, 'wall_seconds': round(seconds),
        'held_out': scores}
