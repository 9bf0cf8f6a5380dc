"""Small networks, one per joint, as mean and variance in numpy (E2.6)."""

import numpy as np


class NetworkDraws:
    """
    S draws of a network with two hidden layers, each drawn for n joints.

    tensors: in_weight (S, n, D, H), in_bias (S, n, H), mid_weight (S, n, H, H), mid_bias
    (S, n, H), out_weight (S, n, H, 2), out_bias (S, n, 2). Outputs: mean, and the logarithm of
    the variance; draws that differ add the variance between them.
    """

    SHAPES = {'in_weight': 'SnDH', 'in_bias': 'SnH', 'mid_weight': 'SnHH', 'mid_bias': 'SnH',
              'out_weight': 'SnH2', 'out_bias': 'Sn2'}

    def __init__(self, tensors):
        self._layers = [(tensors[f'{layer}_weight'], tensors[f'{layer}_bias'][..., None, :])
                        for layer in ('in', 'mid', 'out')]

    def at(self, x):
        """Return mean and variance (..., n) at inputs x (..., n, D)."""
        out = x[..., None, :, None, :]
        for weight, bias in self._layers[:2]:
            out = np.tanh(out @ weight + bias)
        weight, bias = self._layers[2]
        out = (out @ weight + bias)[..., 0, :]
        mean = out[..., 0].mean(axis=-2)
        return mean, np.exp(out[..., 1]).mean(axis=-2) + out[..., 0].var(axis=-2)
