"""A Jordan network (1986): what it remembers is what it last answered, and nothing else (E1.3)."""

import torch
from torch import nn


class Jordan(nn.Module):
    """
    h_t = tanh(W x_t + U y_(t-1) + b), through more such layers without y; y_t = V h_t + c.

    Elman's network hands on its hidden units instead. answers: length of y; an untrained network
    answers zero.
    """

    def __init__(self, inputs, hidden, layers, answers):
        super().__init__()
        self.reads = nn.Linear(inputs, hidden)
        self.remembers = nn.Linear(answers, hidden, bias=False)
        self.behind = nn.ModuleList(nn.Linear(hidden, hidden) for _ in range(layers - 1))
        self.answer_head = nn.Linear(hidden, answers)
        nn.init.zeros_(self.answer_head.weight)
        nn.init.zeros_(self.answer_head.bias)

    def forward(self, x, answer=None):
        """Return y (B, T, answers) of x (B, T, inputs) behind the last answer (B, answers)."""
        read = self.reads(x)
        answer = x.new_zeros(len(x), self.answer_head.out_features) if answer is None else answer
        answers = []
        for step in read.unbind(dim=1):
            out = torch.tanh(step + self.remembers(answer))
            for layer in self.behind:
                out = torch.tanh(layer(out))
            answer = self.answer_head(out)
            answers.append(answer)
        return torch.stack(answers, dim=1), answer
