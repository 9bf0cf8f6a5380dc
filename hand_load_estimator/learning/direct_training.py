"""
Train a direct network (E1.3 to E1.6, E6.1, E6.2) on the same draws as the default method's.

Every step takes the motions and torque errors of a shard with freshly drawn loads: what the load
does to the torque is linear in it, so one motion teaches as many loads as there are passes.
"""

import time
from dataclasses import asdict, dataclass

import numpy as np
import torch

from ..model_file import read_model
from .direct_artefact import write_direct_artefact
from .direct_calibration import (calibrate_direct, direct_scores, inputs_of_shard,
                                 judged_samples)
from .direct_design import NETWORKS, Design
from .direct_network import build_network
from .direct_shards import make_direct_shard
from .objective import divergence
from .random_loads import random_load
from .sequences import DURATION
from .shards import DT
from .training_loop import (SPANS, begin_work, end_work, keep_memory, make_sequences, optimise,
                            pick_device)

# Share of the steps that take sequences whole; the others take PIECE [s] of them, from the start
# or, as a change of load restarts the network in mid motion, from anywhere in the first half.
WHOLE, PIECE = 0.3, 4.0


@dataclass(frozen=True)
class DirectRecipe:
    """As training.Recipe, for a Design; fewer sequences, as each serves many loads."""

    design: Design
    sequences: int = 1280
    calibration: int = 256
    validation: int = 256
    passes: int = 40
    learning_rate: float = 3e-3
    seed: int = 1


def train_direct(model_path, folder, recipe, device='auto', write=print):
    """Train on draws around a torque model file; as training.train."""
    began = time.time()
    keep_memory()
    model, device = read_model(model_path), pick_device(device)
    robot = model.robot
    work = begin_work(folder, model_path, recipe)
    shards = make_sequences(model_path, work, recipe, make_direct_shard, write)
    torch.manual_seed(recipe.seed)
    network = optimise(build_network(robot, recipe.design).to(device), recipe,
                       shards['training'], Loss(robot, recipe), work, write).cpu().eval()
    knots, factors = calibrate_direct(network, robot, shards['calibration'])
    scores = direct_scores(network, robot, knots, factors, shards['validation'])
    write_direct_artefact(folder, network, knots, factors,
                          _card(model, recipe, scores, time.time() - began))
    end_work(work)
    return scores


class Loss:
    """The divergence between labels and answers (E6.1), averaged over judged times."""

    def __init__(self, robot, recipe):
        self._robot, self._seed = robot, recipe.seed
        self._design = recipe.design
        self._joints = [robot.joints.index(name) for name in recipe.design.joints]
        self._peak = torch.tensor(robot.limits.torque[self._joints], dtype=torch.float32)

    def __call__(self, network, shard, step):
        """Return the loss of a network on a shard with the loads of this step."""
        rng = np.random.default_rng([self._seed, 1, step])
        shard = self._cut(rng, shard)
        steps = shard['error'].shape[1]
        load = np.array([random_load(rng, self._robot).to_message() for _ in shard['load']])
        x = inputs_of_shard(self._robot, self._joints, shard, load)
        load = torch.tensor(load, device=x.device, dtype=x.dtype)
        at = judged_samples(steps)
        if self._design.network == 'two_network':
            return self._of_two(network, x, load, shard['error'], at)
        masks = network.masks(len(x), torch.Generator().manual_seed(step))
        mean, std, _ = network(x, at=at, masks=masks)
        # Thinned networks are points: their scatter, not their head, tells how sure they are.
        return self._divergence(mean, network.scale.expand_as(std) if masks is not None else std,
                                load)

    def _cut(self, rng, shard):
        """Return the shard, or a piece of it."""
        if rng.random() < WHOLE:
            return shard
        first = int(rng.integers(shard['error'].shape[1] // 2)) if rng.random() < 0.5 else 0
        rows = slice(first, first + round(PIECE / DT))
        return {**shard, 'motion': shard['motion'][:, :, rows],
                **{name: shard[name][:, rows] for name in ('warmth', 'columns', 'error')}}

    def _divergence(self, mean, std, load):
        return divergence(mean, std ** 2, load)[..., self._design.picked].mean()

    def _of_two(self, network, x, load, error, at):
        first, predicted, corrected, _ = network.passes(x)
        of_load = sum(self._divergence(mean[:, at], std[:, at], load)
                      for mean, std in (first, corrected))
        label = error[..., self._joints] / self._peak.to(x.device)
        return of_load + network.error_loss(predicted, label)


def _card(model, recipe, scores, seconds):
    design = recipe.design
    return {
        'name': f'{NETWORKS[design.network]} for {model.robot.name}',
        'joints': list(model.robot.joints), 'effort_kind': model.robot.effort.kind,
        'network': design.network,
        'outputs': f'mean and standard deviation of {", ".join(design.parameters)}',
        'trained_on': 'draws around the identified torque model; no simulator, no plant',
        'model_recordings': list(model.recordings), 'recipe': asdict(recipe),
        'sequence_seconds': DURATION,
        'seeds': {name: span.start for name, span in SPANS.items()},
        'torch': torch.__version__, 'wall_seconds': round(seconds), 'held_out': scores}
