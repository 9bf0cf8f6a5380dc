"""
Networks from motion and torque difference to the load, with variance (E1.3 to E1.6, E6.1, E6.2).

x_t holds theta, theta', theta'', tau_real - tau_mdl and the temperature of each joint (E3.1), 5 k
numbers for k joints, and whether temperatures are known. Each answers mean and standard deviation
of mass, first moment and inertia (first_moments.py) at every step, an untrained one the prior's; a
Judge turns them into a message's.
"""

from functools import partial

import torch
from torch import nn

from ..estimators.load_prior import load_prior
from .first_moments import message_of, message_prior, moments_prior
from .jordan import Jordan

CELLS = {'lstm_direct': nn.LSTM, 'gru': nn.GRU, 'elman': nn.RNN, 'two_network': nn.LSTM,
         'dropout': nn.LSTM}
# Bounds of the stated standard deviation, in e-folds of the prior's.
LEAST, MOST = -7.0, 0.5
# A window's samples are described by so many numbers each, before they are read side by side.
PER_SAMPLE = 24
# Torque differences are read in shares of the drive's peak, and once more with small ones spread.
SPREAD = 100.0
# Unit of predicted torque errors: share of the drive's peak.
TORQUE_ERROR = 0.01


def inputs_of(robot, joints, motion, difference, warmth):
    """
    Return x (..., 5 k + 1) for joints' indices (k,).

    motion: q, v, a [rad, rad/s, rad/s^2]; difference [Nm]; warmth [K] above the reference, NaN
    where not measured: tensors (..., n) each.
    """
    limits = robot.limits

    def share(value, full):
        return value / torch.tensor(full, dtype=value.dtype, device=value.device)

    q, v, a = motion
    known = torch.isfinite(warmth).any(dim=-1, keepdim=True).to(q.dtype)
    columns = (q, share(v, limits.velocity), share(a, limits.acceleration),
               share(difference, limits.torque), torch.nan_to_num(warmth) / 20.0)
    return torch.cat([c[..., joints] for c in columns] + [known], dim=-1)


def _encoded(x, k):
    """Return x with theta as sine and cosine, and the difference with small ones spread too."""
    spread = torch.asinh(SPREAD * x[..., 3 * k:4 * k]) / 3.0
    return torch.cat([torch.sin(x[..., :k]), torch.cos(x[..., :k]), x[..., k:], spread], dim=-1)


class _Products(nn.Module):
    """
    A layer per sample whose units are products: of sines and cosines, and of torque with those.

    A load's torque is a polynomial in sines and cosines of theta, so products learn its inverse
    from far fewer samples than sums through a bent line do.
    """

    LEVELS = 3

    def __init__(self, inputs, width):
        super().__init__()
        self.levels = nn.ModuleList(nn.Linear(inputs + (width if level else 0), 2 * width)
                                    for level in range(self.LEVELS))

    def forward(self, x):
        """Return (..., width) of (..., inputs)."""
        out = x[..., :0]
        for level in self.levels:
            one, other = level(torch.cat([x, out], dim=-1)).chunk(2, dim=-1)
            out = one * other
        return torch.asinh(out)


class _Recurrent(nn.Module):
    """A layer per sample, then recurrent ones (E1.3). masks thin both for a whole sequence."""

    def __init__(self, inputs, hidden, make_cell):
        super().__init__()
        self.front = _Products(inputs, hidden)
        self.cell = make_cell()

    def forward(self, x, state, at, masks):
        """Return features (B, J, hidden) after the samples `at`, and the state."""
        x = self.front(x)
        if masks is not None:
            x = x * masks[0][:, None]
        x, state = self.cell(x, state)
        x = x if at is None else x[:, at]
        return (x if masks is None else x * masks[1][:, None]), state


class _Windows(nn.Module):
    """The newest samples side by side (E1.4); before there are enough, the first stands in."""

    def __init__(self, inputs, hidden, layers, window):
        super().__init__()
        self.front = nn.Sequential(_Products(inputs, hidden), nn.Linear(hidden, PER_SAMPLE))
        sizes = [window * PER_SAMPLE] + [2 * hidden] * layers
        self.behind = nn.Sequential(*(part for a, b in zip(sizes, sizes[1:])
                                      for part in (nn.Linear(a, b), nn.SiLU())),
                                    nn.Linear(2 * hidden, hidden), nn.SiLU())
        self._window = window

    def forward(self, x, state, at, masks):
        """Return features (B, J, hidden) after the samples `at`, and the state."""
        x = self.front(x)
        before = x[:, :1].expand(-1, self._window - 1, -1) if state is None else state
        x = torch.cat([before, x], dim=1)
        windows = x.unfold(1, self._window, 1)
        windows = windows if at is None else windows[:, at]
        return self.behind(windows.flatten(2)), x[:, x.shape[1] - self._window + 1:]


def _between(design):
    """Return the layers between the features and the head, and how many units they end in."""
    if not design.head_layers:
        return nn.Identity(), design.hidden
    return nn.Sequential(nn.Linear(design.hidden, 2 * design.hidden), nn.SiLU()), 2 * design.hidden


def _backbone(design, inputs):
    hidden, layers = design.hidden, design.layers
    if design.network == 'feedforward':
        return _Windows(inputs, hidden, layers, design.window)
    if design.network == 'jordan':
        cell = partial(Jordan, hidden, hidden, layers, design.answers)
    else:
        cell = partial(CELLS[design.network], hidden, hidden, layers, batch_first=True)
    return _Recurrent(inputs, hidden, cell)


def _answer(design):
    """Return the layers from the features to mean and standard deviation."""
    if design.network == 'jordan':
        return nn.Identity(), nn.Identity()
    between, width = _between(design)
    head = nn.Linear(width, design.answers)
    nn.init.zeros_(head.weight)
    nn.init.zeros_(head.bias)
    return between, head


class DirectNetwork(nn.Module):
    """x -> mean and standard deviation (B, J, 10) of mass, first moment and inertia."""

    def __init__(self, robot, design):
        super().__init__()
        self.design, self._joints = design, len(design.joints)
        centre, scale = moments_prior(load_prior(robot))
        self.register_buffer('centre', centre.float(), persistent=False)
        self.register_buffer('scale', scale.float(), persistent=False)
        self.backbone = _backbone(design, 7 * self._joints + 1)
        self.between, self.head = _answer(design)

    def forward(self, x, state=None, at=None, masks=None):
        """
        Return mean, std (B, J, 10) after the samples `at` (default all), and the state.

        x (B, T, 5 k + 1); state: what the last call returned, to go on behind it.
        """
        out, state = self.backbone(_encoded(x, self._joints), state, at, masks)
        out = self.head(self.between(out))
        learnt = self.design.learnt
        mean = self.centre.expand(*out.shape[:2], 10).clone()
        std = self.scale.expand(*out.shape[:2], 10).clone()
        mean[..., learnt] = mean[..., learnt] + std[..., learnt] * out[..., :len(learnt)]
        std[..., learnt] = std[..., learnt] * torch.exp(out[..., len(learnt):].clamp(LEAST, MOST))
        return mean, std, state

    def masks(self, count, generator):
        """Return masks that thin `count` networks, or None where dropout is not the judge."""
        design = self.design
        if design.network != 'dropout':
            return None
        kept = torch.full((2, count, design.hidden), 1.0 - design.thinned)
        return (torch.bernoulli(kept, generator=generator) / kept).to(self.centre.device)


class TwoNetworks(nn.Module):
    """
    Net A: (motion, difference) -> load; net B: (motion, load) -> torque error (E1.6).

    A answers, B tells what torque error goes with that load and motion, and A answers again with
    the error taken off.
    """

    def __init__(self, robot, design):
        super().__init__()
        self.design, self._joints = design, len(design.joints)
        self.load = DirectNetwork(robot, design)
        self.error = _Recurrent(5 * self._joints + 1 + 10, design.hidden, partial(
            nn.LSTM, design.hidden, design.hidden, batch_first=True))
        self.error_head = nn.Linear(design.hidden, self._joints)
        nn.init.zeros_(self.error_head.weight)
        nn.init.zeros_(self.error_head.bias)

    def forward(self, x, state=None, at=None, masks=None):
        """Return mean, std (B, J, 10) after correction, and the state; as DirectNetwork."""
        *_, (mean, std), state = self.passes(x, state)
        return (mean, std, state) if at is None else (mean[:, at], std[:, at], state)

    def passes(self, x, state=None):
        """
        Return (mean, std) before correction, torque error (B, T, k), (mean, std) after it, state.

        The torque error is in shares of the drives' peaks, as the difference in x.
        """
        first, predicted, second = state or (None,) * 3
        k = self._joints
        mean, std, first = self.load(x, first)
        load = (mean - self.load.centre) / self.load.scale
        motion = torch.cat([_encoded(x, k)[..., :4 * k], x[..., 4 * k:]], dim=-1)
        # Each net learns its own label; nothing of A's is to be learnt through B.
        out, predicted = self.error(torch.cat([motion, load.detach()], dim=-1), predicted,
                                    None, None)
        error = TORQUE_ERROR * self.error_head(out)
        left = torch.cat([x[..., :3 * k], x[..., 3 * k:4 * k] - error.detach(), x[..., 4 * k:]],
                         dim=-1)
        *corrected, second = self.load(left, second)
        return (mean, std), error, tuple(corrected), (first, predicted, second)

    @staticmethod
    def error_loss(predicted, label):
        """Return the loss of torque errors (B, T, k) in shares of the peaks; outliers linear."""
        return nn.functional.smooth_l1_loss(predicted / TORQUE_ERROR, label / TORQUE_ERROR)

    def masks(self, count, generator):
        """Return None: this network is not judged by dropout."""


def build_network(robot, design):
    """Return the untrained network of a Design."""
    return (TwoNetworks if design.network == 'two_network' else DirectNetwork)(robot, design)


class Judge:
    """
    Ask a trained network of a robot for its answer in message order and its reliability index.

    That is its own standard deviation (E6.1), or, for `dropout`, the scatter of `copies` randomly
    thinned networks around their mean (E6.2), the same ones from a fixed seed ever after.
    """

    def __init__(self, robot, network, seed=0):
        self._network, self._copies = network, network.design.copies
        self._masks = network.masks(self._copies, torch.Generator().manual_seed(seed))
        self._prior = [part.float() for part in message_prior(load_prior(robot))]

    @torch.no_grad()
    def __call__(self, x, state=None, at=None):
        """Return mean, std (B, J, 10) and the state; arguments as of the network."""
        mean, std, state = self._moments(x, state, at)
        return *message_of(mean, std, *self._prior), state

    def _moments(self, x, state, at):
        if self._masks is None:
            return self._network(x, state, at)
        many = x.repeat_interleave(self._copies, dim=0)
        mean, std, state = self._network(many, state, at, self._masks.repeat(1, len(x), 1))
        mean, std = (part.unflatten(0, (len(x), self._copies)) for part in (mean, std))
        learnt = self._network.design.learnt
        out = std[:, 0].clone()
        out[..., learnt] = mean[..., learnt].std(dim=1)
        return mean.mean(dim=1), out, state
