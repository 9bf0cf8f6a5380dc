"""A network distilled from the Gaussian process: its inputs, its mean and variance (E2.6)."""

import numpy as np
import torch

from .joint_networks import BATCH, JointLayers, descend, divergence, places

STEPS = 1500


def distil(data, teacher, seed, write=lambda text: None):
    """Return tensors of NetworkDraws that answer as teacher.at over and around DifferenceData."""
    rng = np.random.default_rng(seed)
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        network = JointLayers(data.inputs.shape[1], data.inputs.shape[2])

        def loss():
            x = places(data, rng, BATCH)
            mean, variance = (torch.tensor(part.T) for part in
                              teacher.at(x.swapaxes(0, 1).numpy()))
            own, spread = network(x)
            return divergence(mean, variance, own, spread.exp()).mean()

        descend(network.parameters(), loss, STEPS, write)
    return network.tensors()
