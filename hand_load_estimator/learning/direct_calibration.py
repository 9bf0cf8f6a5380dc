"""What direct networks answer on sequences that training never saw."""

import numpy as np
import torch

from .direct_network import Judge, inputs_of
from .direct_shards import load_torque
from .shards import read_shard
from .stated_intervals import Answers, errors_of, judged_samples


def inputs_of_shard(robot, joints, shard, load=None):
    """
    Return x (B, T, 5 k + 1) of a shard for joints' indices (k,).

    load (B, 10): another load than the shard's, in message order.
    """
    load = shard['load'].cpu().numpy() if load is None else load
    difference = shard['error'] + load_torque(shard['columns'], load)
    return inputs_of(robot, joints, tuple(shard['motion']), difference, shard['warmth'])


def direct_answers(network, robot, paths):
    """Return the Answers of a trained network on the shards at `paths`."""
    judge, joints = Judge(robot, network), [robot.joints.index(j) for j in network.design.joints]
    errors, stds, severe = [], [], []
    for path in paths:
        shard = read_shard(path, 'cpu')
        ends = judged_samples(shard['error'].shape[1])
        mean, std, _ = judge(inputs_of_shard(robot, joints, shard), at=torch.tensor(ends))
        errors.append(errors_of(mean.numpy(), shard['load'].numpy(), ends,
                                shard['begin'].numpy()))
        stds.append(std.numpy())
        severe.append(shard['severe'].numpy() > 0.5)
    return Answers(*(np.concatenate(part) for part in (errors, stds, severe)))
