"""What a direct network remembers from sample to sample, as plain arrays for a checkpoint."""

import numpy as np
import torch


class NetworkMemory:
    """
    Turn the state that a Judge returns into {name: array} and back; judge(x) for x (1, 1, width).

    A state is a tensor or nested tuples of tensors, as the network has it, or None before any
    sample: for a window that is not the same as zeros.
    """

    def __init__(self, judge, width):
        _, _, state = judge(torch.zeros(1, 1, width))
        self._blank = _each(torch.zeros_like, state)

    def arrays_of(self, state):
        """Return {name: array}: whether there is a state, and its tensors in order."""
        tensors = []
        _each(tensors.append, self._blank if state is None else state)
        return {'begun': np.array(float(state is not None)),
                **{f'{k}': tensor.numpy().astype(float) for k, tensor in enumerate(tensors)}}

    def state_of(self, arrays):
        """Return the state that arrays_of was given."""
        if not arrays['begun']:
            return None
        values = (arrays[f'{k}'] for k in range(len(arrays) - 1))
        return _each(lambda blank: torch.tensor(next(values), dtype=blank.dtype), self._blank)


def _each(change, state):
    """Return a state with a function's answer for each of its tensors."""
    if isinstance(state, tuple):
        return tuple(_each(change, part) for part in state)
    return change(state)
