"""What every training shares: seeded steps with progress and time left, resumed after a kill."""

import ctypes
import json
import shutil
import time
from dataclasses import asdict
from itertools import chain
from pathlib import Path

import numpy as np
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save_file

from .. import seeds
from ..errors import ConfigurationError
from ..files.whole_file import whole_file
from ..torque.model_file import undated_digest
from . import shards
from .start import sha256_of

CHECKPOINT_EVERY = 25   # steps
BYTES_PER_SEQUENCE = 1e6   # on disk while training, for six joints
_NOTE, _CHECKPOINT = 'job.json', 'checkpoint.safetensors'
_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4   # glibc's malloc.h


def pick_device(name):
    """Return the torch device for 'auto', 'cpu' or 'cuda'."""
    if name == 'cuda' and not torch.cuda.is_available():
        raise ConfigurationError('--device', 'is not there', name, 'auto or cpu on this machine')
    if name == 'auto':
        name = 'cuda' if torch.cuda.is_available() else 'cpu'
    return torch.device(name)


def keep_memory():
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


def job_of(model_path, model, recipe, start=None):
    """
    Return what a training's result follows from, as JSON has it.

    model: the TorqueModel of the file at model_path; start: None or a Start.
    """
    job = {'recipe': asdict(recipe), 'started_from': None if start is None else start.note,
           'model': {'file': Path(model_path).name, 'sha256': sha256_of(model_path),
                     'undated': undated_digest(model)}}
    # As JSON gives it back: tuples are lists there.
    return json.loads(json.dumps(job))


def spans_of(recipe, start=None):
    """
    Return {'training', 'calibration', 'validation': seeds} of a recipe.

    A fine-tuning (start given) sees draws that no training from scratch comes to.
    """
    count = recipe.sequences if recipe.passes else 0
    training = seeds.TRAINING[:count] if start is None else \
        seeds.TRAINING[len(seeds.TRAINING) - count:]
    return {'training': training, 'calibration': seeds.CALIBRATION[:recipe.calibration],
            'validation': seeds.VALIDATION[:recipe.validation]}


def begin_work(folder, job, spans):
    """Return folder/work, where a training of this job begins or goes on."""
    work = Path(folder) / 'work'
    work.mkdir(parents=True, exist_ok=True)
    _same_job(work, job, sum(map(len, spans.values())))
    return work


def _same_job(work, job, sequences):
    """Note what the work belongs to, where there is room for it; refuse to mix two jobs."""
    note = work / _NOTE
    # A diagnosis that is run again after a kill writes the same model with another date.
    job = {**job, 'model': job['model']['undated']}
    if not note.exists():
        # A kill while it was written left a part of it.
        for part in work.glob(f'{_NOTE}.*.part'):
            part.unlink()
        if any(work.iterdir()):
            raise ConfigurationError(work, 'holds files that are of no training', allowed='no '
                                     f'such folder, or one with a {_NOTE} of this training',
                                     todo='give another --out, or move them')
        needed = BYTES_PER_SEQUENCE * sequences
        free = shutil.disk_usage(work).free
        if free < needed:
            raise ConfigurationError(work, 'has too little room for the training sequences',
                                     f'{free / 1e9:.1f} GB', f'{needed / 1e9:.1f} GB or more')
        with whole_file(note) as part:
            part.write_text(json.dumps(job), encoding='utf-8')
    elif _noted(note) != job:
        raise ConfigurationError(
            work, 'holds the unfinished training of another model, recipe or start, or what was '
            'begun with another learned torque difference',
            todo='remove it or give another --out')


def _noted(note):
    try:
        return json.loads(note.read_text(encoding='utf-8'))
    except ValueError as error:
        raise ConfigurationError(note, f'is damaged ({error})',
                                 todo='remove its folder or give another --out') from None


def end_work(work, made):
    """
    Remove what a finished training wrote, shards `made` as make_sequences returned them.

    Files of others stay, and the folder with them; a kill leaves what another job is refused.
    """
    for path in (*chain(*made.values()), work / _CHECKPOINT):
        # A kill while one was written left parts.
        for written in (path, *path.parent.glob(f'{path.name}.*.part')):
            written.unlink(missing_ok=True)
    for name in made:
        _remove_if_empty(work / name)
    # Last: without it the next training would be refused what is left.
    (work / _NOTE).unlink()
    _remove_if_empty(work)


def _remove_if_empty(folder):
    if not any(folder.iterdir()):
        folder.rmdir()


def make_sequences(model_path, work, spans, make, write):
    """
    Return {use: paths of shards} for spans {use: seeds}, made where missing.

    make: as of shards.write_shards.
    """
    def made(name, span):
        progress = Progress(write, f'sequences ({name})', len(range(0, len(span), shards.BATCH)))
        return shards.write_shards(model_path, work / name, span, make, progress)
    return {name: made(name, span) for name, span in spans.items()}


class _Run:
    """Network, optimiser and schedule of one training, with their checkpoint."""

    def __init__(self, network, recipe, steps, folder):
        self.network = network
        self.optimiser = torch.optim.Adam(self.network.parameters(), lr=recipe.learning_rate)
        # Of ten steps a tenth is the first alone, a rise of no length that torch divides by.
        self.schedule = torch.optim.lr_scheduler.OneCycleLR(
            self.optimiser, recipe.learning_rate, total_steps=max(steps, 1),
            pct_start=0.11 if steps == 10 else 0.1)
        self._path = Path(folder) / _CHECKPOINT
        self.step = 0

    def save(self):
        """Write the checkpoint; a kill leaves the old one or the new one."""
        tensors = {f'network.{k}': v for k, v in self.network.state_dict().items()}
        for index, state in self.optimiser.state_dict()['state'].items():
            tensors |= {f'optimiser.{index}.{k}': v for k, v in state.items()}
        with whole_file(self._path) as part:
            save_file({k: v.contiguous() for k, v in tensors.items()}, part,
                      metadata={'step': str(self.step)})

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


def optimise(network, recipe, paths, loss, work, write):
    """
    Return the network after recipe.passes over the shards, its gradients of `loss` followed.

    network: on its device, initialised; loss(network, shard, step) -> tensor (). What is random
    in a loss must follow from the step, so that a resumed training does the same.
    """
    steps = recipe.passes * len(paths)
    run = _Run(network, recipe, steps, work)
    run.resume()
    device = next(network.parameters()).device
    progress = Progress(write, 'training step', steps, run.step)
    recent = []
    while run.step < steps:
        turn, place = divmod(run.step, len(paths))
        order = np.random.default_rng([recipe.seed, turn]).permutation(len(paths))
        value = loss(network, shards.read_shard(paths[order[place]], device), run.step)
        run.optimiser.zero_grad()
        value.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        run.optimiser.step()
        run.schedule.step()
        run.step += 1
        recent = [*recent[-49:], value.item()]
        if run.step % CHECKPOINT_EVERY == 0 or run.step == steps:
            run.save()
            progress(run.step, f'  divergence {np.mean(recent):.3f}')
    return network
