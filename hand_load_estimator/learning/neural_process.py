"""
A conditional neural process of the no-load torque difference (E2.6).

An encoder turns every context sample (inputs, difference) of a joint into numbers, their mean
stands for the joint, and a decoder answers mean and variance anywhere from that mean. One encoder
and decoder serve all joints: a joint with some of its recorded time as context is one task, and
scaling its difference by a random factor makes many. The context is fixed once learned, so what is
handed over is the decoder with the joint's numbers in its first layer.
"""

import numpy as np
import torch
from torch import nn

from ..errors import ConfigurationError
from ..estimators.network_draws import NetworkDraws
from .joint_networks import HIDDEN, LOG_VARIANCE
from .left_out import left_out

CODE, CONTEXT, STEPS, RATE = 16, 256, 1500, 1e-2
# Samples of one task lie in random stretches of so many, as recordings do.
STRETCH = 64


class _NeuralProcess(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.encoder = nn.Sequential(nn.Linear(width + 2, HIDDEN), nn.Tanh(),
                                     nn.Linear(HIDDEN, CODE))
        self.layers = nn.ModuleList([nn.Linear(width + CODE, HIDDEN), nn.Linear(HIDDEN, HIDDEN),
                                     nn.Linear(HIDDEN, 2)])

    def code(self, x, y, worth):
        """Return (n, CODE): the context's mean by worth, with its logarithm for how much."""
        each = self.encoder(torch.cat([x, y[..., None], worth[..., None]], dim=-1))
        total = worth.sum(-1, keepdim=True)
        return (each * worth[..., None]).sum(-2) / (total + 1e-9)

    def forward(self, code, x):
        """Return mean, log variance (n, N) at x (n, N, D)."""
        out = torch.cat([x, code[:, None].expand(-1, x.shape[1], -1)], dim=-1)
        for layer in self.layers[:2]:
            out = torch.tanh(layer(out))
        out = self.layers[2](out)
        return out[..., 0], out[..., 1].clamp(*LOG_VARIANCE)


def learn_neural_process(data, seed, write=lambda text: None):
    """
    Return (tensors of NetworkDraws, LeftOut) for DifferenceData.

    Left out is the context alone: encoder and decoder have seen all recordings. Raises
    ConfigurationError for recordings too short to hold context and targets apart.
    """
    if len(data.dt) < 2 * STRETCH:
        raise ConfigurationError('recordings', 'are too short for a neural process',
                                 f'{data.dt.sum():.1f} s', 'some seconds of motion or more')
    rng = np.random.default_rng(seed)
    arrays = [np.swapaxes(part, 0, 1) for part in (data.inputs, data.difference, data.worth)]
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        network = _NeuralProcess(data.inputs.shape[2]).double()
    optimiser = torch.optim.Adam(network.parameters(), RATE)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, STEPS)
    for step in range(STEPS):
        optimiser.zero_grad()
        loss = _loss(network, arrays, rng)
        loss.backward()
        optimiser.step()
        schedule.step()
        if (step + 1) % 500 == 0:
            write(f'step {step + 1} of {STEPS}: loss {float(loss.detach()):.3f}')

    def predict(rows):
        return NetworkDraws(_decoder(network, arrays, rows)).at
    everything = np.ones(len(data.dt), dtype=bool)
    return _decoder(network, arrays, everything), left_out(data, predict)


def _loss(network, arrays, rng):
    """Return the mean loss of targets given a context drawn apart from them, joint by joint."""
    count = arrays[0].shape[1]
    starts = rng.permutation(np.arange(0, count - STRETCH + 1, STRETCH))
    stretches = starts[:, None] + np.arange(STRETCH)
    apart = max(1, len(stretches) // 4)
    target = rng.choice(stretches[:apart].ravel(), CONTEXT)
    context = rng.choice(stretches[apart:].ravel(), CONTEXT)
    scale = torch.tensor(rng.choice([-1.0, 1.0], arrays[0].shape[0])
                         * np.exp(rng.normal(0.0, 0.3, arrays[0].shape[0])))[:, None]
    (x, y, w), (x_t, y_t, w_t) = ([torch.tensor(part[:, rows]) for part in arrays]
                                  for rows in (context, target))
    mean, log_variance = network(network.code(x, scale * y, w), x_t)
    # One unit is the residual's noise: the rest of the variance is doubt about the function.
    total = log_variance.exp() + scale ** 2
    fit = -0.5 * ((scale * y_t - mean) ** 2 / total + total.log())
    return -(w_t * fit).sum() / w_t.sum()


def _decoder(network, arrays, rows):
    """Return tensors of NetworkDraws: the decoder for the context of rows (N,) bool."""
    with torch.no_grad():
        code = network.code(*(torch.tensor(part[:, rows]) for part in arrays))
        n, width = len(code), arrays[0].shape[2]
        first, middle, last = network.layers
        weights = {
            'in_weight': first.weight.T[:width].expand(n, -1, -1),
            'in_bias': first.bias + code @ first.weight.T[width:],
            'mid_weight': middle.weight.T.expand(n, -1, -1),
            'mid_bias': middle.bias.expand(n, -1),
            'out_weight': last.weight.T.expand(n, -1, -1), 'out_bias': last.bias.expand(n, -1)}
    return {name: value.detach().numpy()[None].copy() for name, value in weights.items()}
