"""
Train the network: seeded, with progress and time left, resumed after a kill.

From scratch, or from the weights of an artefact (fine-tuning; without a pass it is calibrated
anew and nothing else).
"""

import ctypes
import json
import os
import shutil
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save_file

from .. import seeds
from ..errors import ConfigurationError
from ..load import MESSAGE_ORDER
from ..model_file import read_model
from .artefact import write_artefact
from .calibration import calibrate, held_out_scores
from .features import feature_count
from .network import LoadNetwork
from .objective import answers, divergence
from .sequences import DURATION
from .shards import BATCH, prior_tensors, read_shard, write_shards
from .start import read_start, sha256_of

CHECKPOINT_EVERY = 25   # steps
BYTES_PER_SEQUENCE = 1e6   # on disk while training, for six joints
_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4   # glibc's malloc.h


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


# From an artefact's weights, which know the arm already.
FINE_TUNING = Recipe(sequences=1216, calibration=512, validation=256, passes=3,
                     learning_rate=1e-3)


def pick_device(name):
    """Return the torch device for 'auto', 'cpu' or 'cuda'."""
    if name == 'cuda' and not torch.cuda.is_available():
        raise ConfigurationError('--device', 'is not there', name, 'auto or cpu on this machine')
    if name == 'auto':
        name = 'cuda' if torch.cuda.is_available() else 'cpu'
    return torch.device(name)


def _keep_memory():
    """
    Have glibc keep freed memory: giving the large tensors of every step back to the system and
    fetching them anew takes as long as the arithmetic. Elsewhere nothing happens.
    """
    mallopt = getattr(ctypes.CDLL(None), 'mallopt', None)
    if mallopt is not None:
        mallopt(_M_MMAP_MAX, 0)
        mallopt(_M_TRIM_THRESHOLD, 2 ** 31 - 1)


class Progress:
    """One line that says how far, how fast and how long still."""

    def __init__(self, write, what, total, done=0):
        self._write, self._what, self._total = write, what, total
        self._began, self._first = time.monotonic(), done

    def __call__(self, done, note=''):
        """Report `done` of the total."""
        spent = time.monotonic() - self._began
        rate = (done - self._first) / spent if spent > 0.0 else 0.0
        left = (self._total - done) / rate if rate > 0.0 else float('nan')
        self._write(f'{self._what} {done}/{self._total}  {rate:.2f}/s  {left / 60.0:.1f} min left'
                    f'{note}')


class _Run:
    """Network, optimiser and schedule of one training, with their checkpoint."""

    def __init__(self, robot, recipe, steps, folder, device, start):
        torch.manual_seed(recipe.seed)
        self.network = LoadNetwork(feature_count(robot.n), robot.n, recipe.hidden)
        if start is not None:
            start.put_into(self.network)
        self.network.to(device)
        self.optimiser = torch.optim.Adam(self.network.parameters(), lr=recipe.learning_rate)
        self.schedule = torch.optim.lr_scheduler.OneCycleLR(
            self.optimiser, recipe.learning_rate, total_steps=max(steps, 1), pct_start=0.1)
        self._path = Path(folder) / 'checkpoint.safetensors'
        self.step = 0

    def save(self):
        """Write the checkpoint; a kill leaves the old one or the new one."""
        tensors = {f'network.{k}': v for k, v in self.network.state_dict().items()}
        for index, state in self.optimiser.state_dict()['state'].items():
            tensors |= {f'optimiser.{index}.{k}': v for k, v in state.items()}
        part = self._path.with_suffix('.part')
        save_file({k: v.contiguous() for k, v in tensors.items()}, part,
                  metadata={'step': str(self.step)})
        os.replace(part, self._path)

    def resume(self):
        """Go on from the checkpoint when there is one."""
        if not self._path.exists():
            return
        tensors = load_file(self._path)
        self.network.load_state_dict({k[8:]: v for k, v in tensors.items()
                                      if k.startswith('network.')})
        state = self.optimiser.state_dict()
        for name, value in tensors.items():
            if name.startswith('optimiser.'):
                _, index, key = name.split('.')
                state['state'].setdefault(int(index), {})[key] = value
        self.optimiser.load_state_dict(state)
        with safe_open(self._path, 'pt') as file:
            self.step = int(file.metadata()['step'])
        for _ in range(self.step):
            self.schedule.step()


def train(model_path, folder, recipe=Recipe(), device='auto', write=print, start_from=None):
    """
    Train on draws around a torque model file and write the artefact into `folder`.

    start_from: folder of an artefact whose weights are the first ones; its number of hidden units
    holds. With no passes these weights stay and only their calibration is made anew. Work in
    progress lies in folder/work and is picked up by the next call with the same recipe, model and
    start; it is removed at the end. Raises ConfigurationError for a wrong model, start or device.
    """
    began = time.time()
    _keep_memory()
    model, device = read_model(model_path), pick_device(device)
    start = None if start_from is None else read_start(start_from, model.robot)
    recipe = recipe if start is None else start.sized(recipe)
    job = {'recipe': asdict(recipe), 'started_from': None if start is None else start.note,
           'model': {'file': Path(model_path).name, 'sha256': sha256_of(model_path)}}
    spans, work = _seeds_of(recipe, start), Path(folder) / 'work'
    work.mkdir(parents=True, exist_ok=True)
    _same_job(work, job, sum(map(len, spans.values())))
    shards = {name: write_shards(model_path, work / name, span, Progress(
        write, f'sequences ({name})', len(range(0, len(span), BATCH))))
        for name, span in spans.items()}
    network = _optimise(model.robot, recipe, shards['training'], work, device, write, start)
    network = network.cpu()
    prior = prior_tensors(model.robot)
    factors = calibrate(network, shards['calibration'], prior)
    scores = held_out_scores(network, factors, shards['validation'], prior)
    weights = {k: v.numpy() for k, v in network.state_dict().items()}
    write_artefact(folder, weights, factors,
                   _card(model, job, spans, scores, time.time() - began))
    _clean(work)
    return scores


def _seeds_of(recipe, start):
    """Return {use: seeds}. A fine-tuning sees draws that no training from scratch comes to."""
    count = recipe.sequences if recipe.passes else 0
    training = seeds.TRAINING[:count] if start is None else \
        seeds.TRAINING[len(seeds.TRAINING) - count:]
    return {'training': training, 'calibration': seeds.CALIBRATION[:recipe.calibration],
            'validation': seeds.VALIDATION[:recipe.validation]}


def _same_job(work, job, sequences):
    """Note what the work belongs to, where there is room for it; refuse to mix two jobs."""
    note = work / 'job.json'
    if not note.exists():
        needed = BYTES_PER_SEQUENCE * sequences
        free = shutil.disk_usage(work).free
        if free < needed:
            raise ConfigurationError(work, 'has too little room for the training sequences',
                                     f'{free / 1e9:.1f} GB', f'{needed / 1e9:.1f} GB or more')
        part = note.with_suffix('.part')
        part.write_text(json.dumps(job), encoding='utf-8')
        os.replace(part, note)
    elif json.loads(note.read_text(encoding='utf-8')) != job:
        raise ConfigurationError(
            work, 'holds the unfinished training of another model, recipe or start',
            todo='remove it or give another --out')


def _optimise(robot, recipe, paths, work, device, write, start):
    steps = recipe.passes * len(paths)
    run = _Run(robot, recipe, steps, work, device, start)
    run.resume()
    prior = [t.to(device) for t in prior_tensors(robot)]
    progress = Progress(write, 'training step', steps, run.step)
    recent = []
    while run.step < steps:
        turn, place = divmod(run.step, len(paths))
        order = np.random.default_rng([recipe.seed, turn]).permutation(len(paths))
        shard = read_shard(paths[order[place]], device)
        mean, variance, _ = answers(run.network, shard, *prior)
        loss = divergence(mean, variance, shard['load']).mean()
        run.optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(run.network.parameters(), 1.0)
        run.optimiser.step()
        run.schedule.step()
        run.step += 1
        recent = [*recent[-49:], loss.item()]
        if run.step % CHECKPOINT_EVERY == 0 or run.step == steps:
            run.save()
            progress(run.step, f'  divergence {np.mean(recent):.3f}')
    return run.network


def _card(model, job, spans, scores, seconds):
    return {
        'name': f'LSTM load network for {model.robot.name}',
        'joints': list(model.robot.joints), 'effort_kind': model.robot.effort.kind,
        'outputs': 'correction and precision per joint for the recursive regression; shift and '
                   f'spread of {", ".join(MESSAGE_ORDER)}',
        'trained_on': 'draws around the identified torque model; no simulator, no plant',
        'model_recordings': list(model.recordings), **job, 'sequence_seconds': DURATION,
        'seeds': {name: span.start for name, span in spans.items()},
        'torch': torch.__version__, 'wall_seconds': round(seconds), 'held_out': scores}


def _clean(work):
    for path in sorted(work.rglob('*'), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    work.rmdir()
