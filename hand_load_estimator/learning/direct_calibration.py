"""
Make 95 % mean 95 % for direct networks, and score them, on sequences training never saw.

How far a network's index is off depends on how sure it is: early answers rest on the prior, late
ones on what it has learnt. So the factors are a function of the standard deviation it states.
"""

import numpy as np
import torch

from ..load import MESSAGE_ORDER
from .calibration import NORMAL_95, TOLD
from .direct_network import Judge, inputs_of
from .direct_shards import load_torque
from .features import REFRESH
from .objective import JUDGED
from .shards import read_shard

# Stated deviations are parted into so many equally frequent ranges, each with its factor.
RANGES = 6
# No logarithm of nothing, where thinned networks agree to the last bit.
LEAST_STD = 1e-9


def judged_samples(steps):
    """Return the samples (J,) of a sequence of so many steps after which answers are judged."""
    last = torch.tensor([(k + 1) * REFRESH - 1 for k in JUDGED])
    return last[last < steps]


def inputs_of_shard(robot, joints, shard, load=None):
    """
    Return x (B, T, 5 k + 1) of a shard for joints' indices (k,).

    load (B, 10): another load than the shard's, in message order.
    """
    load = shard['load'].cpu().numpy() if load is None else load
    difference = shard['error'] + load_torque(shard['columns'], load)
    return inputs_of(robot, joints, tuple(shard['motion']), difference, shard['warmth'])


def _answers(network, robot, paths):
    """Return error, std (cases, J, 10), NaN where nothing is judged, and severe (cases,)."""
    judge, joints = Judge(network), [robot.joints.index(j) for j in network.design.joints]
    errors, stds, severe = [], [], []
    for path in paths:
        shard = read_shard(path, 'cpu')
        ends = judged_samples(shard['error'].shape[1])
        mean, std, _ = judge(inputs_of_shard(robot, joints, shard), at=ends)
        error = mean - shard['load'][:, None]
        error[ends[None] <= shard['begin'][:, None]] = float('nan')
        error[shard['load'][:, 0] < 0.02, :, 1:4] = float('nan')
        errors.append(error)
        stds.append(std)
        severe.append(shard['severe'] > 0.5)
    return torch.cat(errors).numpy(), torch.cat(stds).numpy(), torch.cat(severe).numpy()


def calibrate_direct(network, robot, paths):
    """
    Return knots (P, RANGES) of log std and factors (P, RANGES) on it for 95 % coverage here.

    On arms without an undeclared effect that stands out, as calibration.calibrate.
    """
    errors, stds, severe = _answers(network, robot, paths)
    pairs = [factors_of(*(x[~severe][:, :, place].ravel() for x in (errors, stds)))
             for place in network.design.picked]
    return tuple(np.array(part) for part in zip(*pairs))


def factors_of(error, std):
    """Return knots (RANGES,) and factors (RANGES,) from errors, NaN left out, and stated std."""
    std = np.maximum(std[np.isfinite(error)], LEAST_STD)
    ratio = np.abs(error[np.isfinite(error)]) / std
    parts = np.array_split(np.argsort(std, kind='stable'), RANGES)
    return ([np.median(np.log(std[part])) for part in parts],
            [np.quantile(ratio[part], 0.95) / NORMAL_95 for part in parts])


def calibrated(std, picked, knots, factors):
    """Return std (..., 10) with the factors put on the parameters at places `picked`."""
    out = np.array(std, dtype=float)
    for place, x, y in zip(picked, knots, factors):
        stated = np.maximum(out[..., place], LEAST_STD)
        out[..., place] = stated * np.interp(np.log(stated), x, y)
    return out


def direct_scores(network, robot, knots, factors, paths):
    """Return coverage per parameter and the mass's RMSE over time, for the card."""
    errors, stds, severe = _answers(network, robot, paths)
    picked = network.design.picked
    inside = np.abs(errors) < NORMAL_95 * calibrated(stds, picked, knots, factors)
    known, scores = np.isfinite(errors), {}
    for name, cases in (('', ~severe), ('_with_undeclared_effect', severe)):
        share = (inside & known)[cases].sum(axis=(0, 1)) \
            / np.maximum(known[cases].sum(axis=(0, 1)), 1)
        scores[f'coverage_of_95{name}'] = {
            MESSAGE_ORDER[k]: round(float(share[k]), 4) for k in picked}
    if 0 in picked:
        mass = errors[:, [JUDGED.index(k) for k in TOLD], 0]
        scores['mass_rmse_kg'] = {
            f'{(k + 1) / 10:g} s': round(float(np.sqrt(np.nanmean(column ** 2))), 4)
            for k, column in zip(TOLD, mass.T)}
    return scores
