"""Small networks, one per joint, that the function alternatives of E2.6 share in training."""

import numpy as np
import torch
from torch import nn

HIDDEN = 24
PLACES = 512
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
    """Lower a loss() that is the same at every call, by L-BFGS: small networks, few places."""
    optimiser = torch.optim.LBFGS(list(parameters), max_iter=steps, history_size=30,
                                  tolerance_change=1e-7, line_search_fn='strong_wolfe')

    def closure():
        optimiser.zero_grad()
        value = loss()
        value.backward()
        return value

    first = float(optimiser.step(closure).detach())
    write(f'loss {first:.3f} fell to {float(loss().detach()):.3f}')


def answers_to_learn(data, teacher, seed):
    """
    Return inputs (n, PLACES, D) as torch, and mean and variance (n, PLACES) of teacher.at there.

    Half are where the data are, half anywhere in half as wide a region again around them.
    """
    total, n, width = data.inputs.shape
    rng = np.random.default_rng(seed)
    low, high = data.inputs.min(axis=0), data.inputs.max(axis=0)
    middle, reach = 0.5 * (low + high), 0.75 * (high - low) + 1e-3
    anywhere = middle + reach * rng.uniform(-1.0, 1.0, (PLACES - PLACES // 2, n, width))
    x = np.concatenate([data.inputs[rng.choice(total, PLACES // 2)], anywhere])
    mean, variance = teacher.at(x)
    return tuple(torch.tensor(np.swapaxes(part, 0, 1)) for part in (x, mean, variance))
