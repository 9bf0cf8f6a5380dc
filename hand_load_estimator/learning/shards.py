"""Batches of training sequences on disk, made once, in parallel, and picked up after a kill."""

from contextlib import closing
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file, save_file

from ..estimators.load_prior import load_prior
from ..estimators.regression import MOVING
from ..files.whole_file import whole_file
from ..torque.model_file import read_model
from ..workers import worker_results
from .features import REFRESH, SlowResidual, features
from .regression_layer import (chunk_sums, marginal, message_moments, products_of_shape,
                               shape_posterior)
from .sequences import EVERY, RATE, SequenceMaker

BATCH = 64
DT = EVERY / RATE


def prior_tensors(robot):
    """Return the LoadPrior's mean and std as float64 tensors (10,)."""
    prior = load_prior(robot)
    return torch.tensor(prior.mean), torch.tensor(prior.std)


def bayes_pass(robot, columns, difference, weights):
    """
    Return innovation [Nm], variance of the load's torque [Nm^2], that torque [Nm], (B, T, n)
    each, and relative std (B, T, 10), as the plain regression has them.

    At each step they come from the posterior of the last finished chunk of REFRESH samples, as
    in the running estimator.
    """
    mean, std = prior_tensors(robot)
    matrix, vector = chunk_sums(columns, difference, weights, REFRESH)
    load_matrix, load_vector = marginal(matrix.double(), vector.double())
    shape, covariance = shape_posterior(load_matrix, load_vector, mean, std)
    _, variance = message_moments(shape, covariance)
    _, prior_variance = message_moments(mean, torch.diag(std ** 2))
    products, jacobian = products_of_shape(shape)
    spread = jacobian @ covariance @ jacobian.transpose(-1, -2)
    nuisance = torch.linalg.solve(
        matrix[..., 10:, 10:].double() + torch.eye(matrix.shape[-1] - 10, dtype=torch.float64),
        (vector[..., 10:].double()
         - (matrix[..., 10:, :10].double() @ products[..., None]).squeeze(-1)))
    known = torch.cat([products, nuisance], dim=-1)
    first, slope = products_of_shape(mean)
    first = torch.cat([first, torch.zeros(nuisance.shape[-1], dtype=torch.float64)])
    known = _delayed(known, first, columns)
    spread = _delayed(spread, slope @ torch.diag(std ** 2) @ slope.T, columns)
    relative = _delayed(torch.sqrt(variance / prior_variance),
                        torch.ones(10, dtype=torch.float64), columns)
    load = columns[..., :10]
    torque = (load @ known[..., :10, None]).squeeze(-1)
    innovation = difference - (columns @ known[..., None]).squeeze(-1)
    return innovation, ((load @ spread) * load).sum(dim=-1).clamp(min=0.0), torque, relative


def _delayed(values, first, like):
    """Return values (B, C, ...) of the chunk before, for each of its samples."""
    shifted = torch.cat([first.expand(len(values), 1, *first.shape), values[:, :-1]], dim=1)
    return shifted.repeat_interleave(REFRESH, dim=1).to(like.dtype)


def slow_residuals(innovation, variance, density):
    """Return (2, B, T, n): what SlowResidual says along innovations (B, T, n)."""
    track = SlowResidual(innovation[:, 0].shape)
    rows = [track.update(innovation[:, k], variance[:, k], density[:, k], DT)
            for k in range(innovation.shape[1])]
    return np.stack([np.stack(row) for row in rows], axis=2)


def moves(velocity):
    """Tell where any joint moves (B, T), of velocities (B, T, n) [rad/s]."""
    return velocity.abs().amax(dim=-1) > MOVING


def make_shard(maker, robot, seeds):
    """Return the tensors of one batch of sequences."""
    sequences = [maker.make(seed) for seed in seeds]
    stack = {name: torch.tensor(np.stack([getattr(s, name) for s in sequences]))
             for name in vars(sequences[0])}
    weights = DT / stack['density']
    *load, relative = bayes_pass(robot, stack['columns'], stack['difference'], weights)
    slow = slow_residuals(load[0].numpy(), load[1].numpy(), stack['density'].numpy())
    inputs = np.stack([features(
        robot.limits, (s.rmse, s.intensity), np.moveaxis(s.motion, 1, 0), s.warmth,
        (s.z, s.doubt, s.density), s.difference, [x[k].numpy() for x in load],
        slow[:, k], relative[k].numpy()) for k, s in enumerate(sequences)])
    return {'inputs': torch.tensor(inputs, dtype=torch.float32), 'columns': stack['columns'],
            'difference': stack['difference'], 'weights': weights, 'level': stack['level'],
            'moving': moves(stack['motion'][:, :, 1]), 'load': stack['load'],
            'begin': stack['begin'], 'severe': stack['severe']}


def _write_shard(model_path, seeds, path, make):
    torch.set_num_threads(1)
    model = read_model(model_path)
    shard = make(SequenceMaker(model), model.robot, seeds)
    with whole_file(path) as part:
        save_file({k: v.contiguous() for k, v in shard.items()}, part)
    return path


def write_shards(model_path, folder, seeds, make, progress):
    """
    Make the shards of a range of seeds below `folder` and return their paths.

    Shards that are there already are kept. make(maker, robot, seeds) gives the tensors of one;
    progress(done) is called as they come.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    parts = [seeds[k:k + BATCH] for k in range(0, len(seeds), BATCH)]
    paths = [folder / f'{part[0]}_{len(part)}.safetensors' for part in parts]
    todo = [(part, path) for part, path in zip(parts, paths) if not path.exists()]
    done = len(parts) - len(todo)
    calls = [(str(model_path), list(part), path, make) for part, path in todo]
    with closing(worker_results(_write_shard, calls)) as written:
        for done, _ in enumerate(written, done + 1):
            progress(done)
    return paths


def read_shard(path, device):
    """Return the tensors of one shard on a device."""
    return load_file(path, device=str(device))
