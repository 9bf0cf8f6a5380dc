"""A network distilled from the Gaussian process: its inputs, its mean and variance (E2.6)."""

import torch

from .joint_networks import JointLayers, answers_to_learn, descend, divergence

STEPS = 400


def distil(data, teacher, seed, write=lambda text: None):
    """Return tensors of NetworkDraws that answer as teacher.at over and around DifferenceData."""
    x, mean, variance = answers_to_learn(data, teacher, seed)
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        network = JointLayers(len(x), x.shape[-1])

    def loss():
        own, log_variance = network(x)
        return divergence(mean, variance, own, log_variance.exp()).mean()

    descend(network.parameters(), loss, STEPS, write)
    return network.tensors()
