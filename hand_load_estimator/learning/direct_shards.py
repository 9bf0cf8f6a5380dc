"""
Batches of sequences for direct networks: what is not the load's kept apart from its columns.

So every pass over a motion may carry another load, and the torque error that the second of two
networks learns (E1.6) is there as a label.
"""

import numpy as np
import torch

from ..load import products_from_message


def make_direct_shard(maker, robot, seeds):
    """
    Return the tensors of one batch of sequences, B of T steps.

    motion (3, B, T, n): q, v, a; warmth (B, T, n); error (B, T, n) [Nm]: the torque difference
    less the load's; columns (B, T, n, 10); load, begin, severe as of Sequence.
    """
    sequences = [maker.make(seed) for seed in seeds]
    stack = {name: torch.tensor(np.stack([getattr(s, name) for s in sequences]))
             for name in ('motion', 'warmth', 'difference', 'load', 'begin', 'severe')}
    columns = torch.tensor(np.stack([s.columns[:, :, :10] for s in sequences]))
    motion = stack['motion'].permute(2, 0, 1, 3).contiguous()
    return {'motion': motion, 'warmth': stack['warmth'], 'columns': columns,
            'error': stack['difference'] - load_torque(columns, stack['load'].numpy()),
            'load': stack['load'], 'begin': stack['begin'], 'severe': stack['severe']}


def load_torque(columns, load):
    """Return K m (B, T, n) [Nm] of columns (B, T, n, 10) and loads (B, 10) in message order."""
    products = torch.tensor(products_from_message(load), dtype=columns.dtype,
                            device=columns.device)
    return (columns @ products[:, None, :, None]).squeeze(-1)
