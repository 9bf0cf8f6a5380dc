"""
A Bayesian network fitted to the Gaussian process' predictive distribution (E2.6, GP Net).

Mean-field: every weight is a normal of its own. Mean and variance of the function come from the
spread of networks drawn from them, and are fitted to those of the process; what is handed over
are a few draws.
"""

import torch
from torch import nn

from .joint_networks import (JointLayers, answers_to_learn, descend, divergence,
                             run_layers)

DRAWS, STEPS = 8, 300
FIRST_LOG_STD = -3.0


class _MeanField(nn.Module):
    """Normals over the weights of JointLayers."""

    def __init__(self, n, width):
        super().__init__()
        self.middle = JointLayers(n, width)
        self.log_std = nn.ParameterDict({
            name: nn.Parameter(torch.full_like(value, FIRST_LOG_STD))
            for name, value in self.middle.named_parameters()})

    def draw(self, noise):
        """Return layers (S, n, ., .) for standard normal noise of the same names."""
        return {name: value + self.log_std[name].exp() * noise[name]
                for name, value in self.middle.named_parameters()}

    def noise(self, generator):
        """Return standard normal noise for DRAWS draws, opposite in pairs."""
        out = {}
        for name, value in self.middle.named_parameters():
            half = torch.randn((DRAWS // 2, *value.shape), dtype=torch.double,
                               generator=generator)
            out[name] = torch.cat([half, -half])
        return out


def learn_bayesian_network(data, teacher, seed, write=lambda text: None):
    """Return tensors of NetworkDraws whose spread is teacher.at's over DifferenceData."""
    x, mean, variance = answers_to_learn(data, teacher, seed)
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        network = _MeanField(len(x), x.shape[-1])
    # The draws are handed over, so they are what is fitted: fixed noise, free normals.
    noise = network.noise(torch.Generator().manual_seed(seed))

    def loss():
        own, log_variance = run_layers(network.draw(noise), x)
        spread = own.var(dim=0, unbiased=False) + log_variance.exp().mean(dim=0)
        return divergence(mean, variance, own.mean(dim=0), spread).mean()

    descend(network.parameters(), loss, STEPS, write)
    return {name: value.detach().numpy() for name, value in network.draw(noise).items()}
