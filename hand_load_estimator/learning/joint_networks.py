"""Small networks, one per joint, that the function alternatives of E2.6 share in training."""

import numpy as np
import torch
from torch import nn

HIDDEN = 24
BATCH, RATE = 512, 5e-3
# Between these a logarithm of variance is believed, in units of the residual's variance.
LOG_VARIANCE = (-12.0, 4.0)


class JointLayers(nn.Module):
    """Two hidden layers and (mean, log variance), drawn apart for each of n joints."""

    def __init__(self, n, width):
        super().__init__()
        sizes = {'in': (width, HIDDEN), 'mid': (HIDDEN, HIDDEN), 'out': (HIDDEN, 2)}
        for name, (fan, out) in sizes.items():
            self.register_parameter(f'{name}_weight', nn.Parameter(
                torch.randn(n, fan, out, dtype=torch.double) / fan ** 0.5))
            self.register_parameter(f'{name}_bias', nn.Parameter(
                torch.zeros(n, out, dtype=torch.double)))

    def forward(self, x):
        """Return mean, log variance (n, N) at x (n, N, D)."""
        return run_layers(dict(self.named_parameters()), x)

    def tensors(self):
        """Return the tensors of NetworkDraws with a single draw."""
        return {name: value.detach().numpy()[None] for name, value in self.named_parameters()}


def run_layers(weights, x):
    """Return mean, log variance (..., n, N) of layers (..., n, ., .) at x (..., n, N, D)."""
    for layer in ('in', 'mid'):
        x = torch.tanh(x @ weights[f'{layer}_weight'] + weights[f'{layer}_bias'][..., None, :])
    out = x @ weights['out_weight'] + weights['out_bias'][..., None, :]
    return out[..., 0], out[..., 1].clamp(*LOG_VARIANCE)


def divergence(mean, variance, mean_of, variance_of):
    """Return KL(N(mean, variance) || N(mean_of, variance_of)), one number per place."""
    return 0.5 * (variance / variance_of + (mean - mean_of) ** 2 / variance_of - 1.0
                  + torch.log(variance_of / variance))


def descend(parameters, loss, steps, write):
    """Lower loss() by Adam; the rate falls to nothing."""
    parameters = list(parameters)
    optimiser = torch.optim.Adam(parameters, RATE)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    for step in range(steps):
        optimiser.zero_grad()
        value = loss()
        value.backward()
        optimiser.step()
        schedule.step()
        if (step + 1) % 500 == 0:
            write(f'step {step + 1} of {steps}: loss {float(value.detach()):.3f}')


def places(data, rng, count):
    """
    Return inputs (n, count, D) to compare functions at, as torch.

    Half are where the data are, half anywhere in half as wide a region again around them.
    """
    total, n, width = data.inputs.shape
    low, high = data.inputs.min(axis=0), data.inputs.max(axis=0)
    middle, reach = 0.5 * (low + high), 0.75 * (high - low) + 1e-3
    anywhere = middle + reach * rng.uniform(-1.0, 1.0, (count - count // 2, n, width))
    seen = data.inputs[rng.choice(total, count // 2)]
    return torch.tensor(np.swapaxes(np.concatenate([seen, anywhere]), 0, 1))
