"""
The forward pass of method `lstm`'s network, sample by sample.

In numpy, because one sample through torch costs more than the arithmetic.
"""

import numpy as np

from ..learning.network_bounds import CORRECTION, SHIFT, SPREAD


def _gates(weights):
    """
    Return (F + H + 1, 4 H) for inputs, output and a 1 side by side; gate order i, f, o, g.

    A sigmoid is half a tanh of half its argument, so that one tanh serves all gates.
    """
    bias = weights['lstm.bias_ih_l0'] + weights['lstm.bias_hh_l0']
    joined = np.concatenate([weights['lstm.weight_ih_l0'], weights['lstm.weight_hh_l0'],
                             bias[:, None]], axis=1)
    hidden = len(bias) // 4
    order = np.r_[:2 * hidden, 3 * hidden:4 * hidden, 2 * hidden:3 * hidden]
    halved = np.repeat([0.5, 0.5, 0.5, 1.0], hidden)
    return np.ascontiguousarray((joined[order] * halved[:, None]).T)


def _head(weights, name, unit):
    """Return matrix and bias of a head with each output in its unit."""
    return (np.ascontiguousarray((weights[f'{name}.weight'] / unit[:, None]).T),
            weights[f'{name}.bias'] / unit)


class LstmCell:
    """
    One LSTM layer run along every joint, and its heads; torch's gate order i, f, g, o.

    memory: output and cell state, (n, H) each; fingerprint: numbers that differ where weights do.
    """

    def __init__(self, weights, joints):
        self._gates = _gates(weights)
        self._load_bounds = np.repeat([SHIFT, SPREAD], 10)
        self._joint = _head(weights, 'joint_head', np.ones(1))
        # A tanh that is bounded by its slope at zero.
        self._load = _head(weights, 'load_head', self._load_bounds)
        self._joints = joints
        self.fingerprint = np.array([np.abs(value).sum() for value in weights.values()])
        self.restart()

    def restart(self):
        """Forget the past."""
        self.memory = np.zeros((2, self._joints, self._gates.shape[1] // 4))
        # What the gates see: inputs, output, and a constant for the bias.
        self._seen = np.ones((self._joints, len(self._gates)))

    def step(self, inputs):
        """Return correction (n,), shift, spread (10,) for inputs (n, F)."""
        h, c = self.memory
        hidden = c.shape[1]
        seen = self._seen
        seen[:, :-hidden - 1], seen[:, -hidden - 1:-1] = inputs, h
        gates = seen.dot(self._gates)
        np.tanh(gates, out=gates)
        opened = gates[:, :3 * hidden]
        opened *= 0.5
        opened += 0.5
        c = opened[:, hidden:2 * hidden] * c + opened[:, :hidden] * gates[:, 3 * hidden:]
        h = opened[:, 2 * hidden:] * np.tanh(c)
        self.memory = h, c
        correction = CORRECTION * np.tanh(h.dot(self._joint[0]) + self._joint[1])
        load = self._load_bounds * np.tanh(h.ravel().dot(self._load[0]) + self._load[1])
        return correction[:, 0], load[:10], load[10:]
