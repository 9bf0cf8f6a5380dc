"""
The LSTM in front of and behind the recursive regression (E1.3, E4.1, E6.1).

One LSTM runs along every joint with the same weights (what friction does is alike in all of them),
told which joint it is. Each step it reads the joint's features and says what torque the model
lacks (correction); and, for the load, how far the regression's answer should move within its own
standard deviation (shift) and how wide it really is (spread). What a sample is worth is left to
physics: a learned precision made the mean of arms outside its draws worse by a fifth.
All outputs begin at zero, where the network does nothing: what it does is learnt.
"""

import torch
from torch import nn

from .network_bounds import CORRECTION, SHIFT, SPREAD


class LoadNetwork(nn.Module):
    """inputs of a joint -> LSTM(hidden) -> its correction; all joints -> shift, spread."""

    def __init__(self, inputs, joints, hidden):
        super().__init__()
        self.lstm = nn.LSTM(inputs, hidden, batch_first=True)
        self.joint_head = nn.Linear(hidden, 1)
        self.load_head = nn.Linear(joints * hidden, 20)
        for head in (self.joint_head, self.load_head):
            nn.init.zeros_(head.weight)
            nn.init.zeros_(head.bias)

    def forward(self, inputs):
        """Return correction (B, T, n), shift, spread (B, T, 10) of inputs (B, T, n, F)."""
        b, t, n, f = inputs.shape
        out, _ = self.lstm(inputs.transpose(1, 2).reshape(b * n, t, f))
        out = out.reshape(b, n, t, -1).transpose(1, 2)
        joint, load = self.joint_head(out), self.load_head(out.reshape(b, t, -1))
        return (CORRECTION * torch.tanh(joint[..., 0]),
                SHIFT * torch.tanh(load[..., :10] / SHIFT),
                SPREAD * torch.tanh(load[..., 10:] / SPREAD))
