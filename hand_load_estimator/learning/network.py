"""
The LSTM in front of and behind the recursive regression (E1.3, E4.1, E6.1).

Each step it reads the features and says, per joint, what torque the model lacks (correction) and
how much the sample is worth (gain of its precision); and, for the load, how far the regression's
answer should move within its own standard deviation (shift) and how wide it really is (spread).
All outputs begin at zero, where the network does nothing: what it does is learnt.
"""

import torch
from torch import nn

from .network_bounds import CORRECTION, GAIN, SHIFT, SPREAD


class LoadNetwork(nn.Module):
    """inputs -> LSTM(hidden) -> correction (n), gain (n), shift (10), spread (10)."""

    def __init__(self, inputs, joints, hidden):
        super().__init__()
        self.joints = joints
        self.lstm = nn.LSTM(inputs, hidden, batch_first=True)
        self.head = nn.Linear(hidden, 2 * joints + 20)
        nn.init.zeros_(self.head.weight)
        nn.init.zeros_(self.head.bias)

    def forward(self, inputs):
        """Return correction, gain (B, T, n), shift, spread (B, T, 10) of inputs (B, T, F)."""
        out = self.head(self.lstm(inputs)[0])
        n = self.joints
        return (CORRECTION * torch.tanh(out[..., :n]),
                GAIN * torch.tanh(out[..., n:2 * n] / GAIN),
                SHIFT * torch.tanh(out[..., 2 * n:2 * n + 10] / SHIFT),
                SPREAD * torch.tanh(out[..., 2 * n + 10:] / SPREAD))
