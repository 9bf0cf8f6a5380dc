"""
What training minimises: the divergence between labels and predicted normals (E6.1).

The label of each of the ten parameters is a normal of small stated width around the truth;
KL(label || prediction) is, up to a constant, (error^2 + width^2) / (2 variance) + log std. The
Jensen-Shannon divergence is the mean of KL(label || middle) and KL(prediction || middle), where
the middle has half of either density; it is log 2 at most, so that no answer far off rules.
"""

import math

import torch
import torch.nn.functional as F

from .features import REFRESH
from .regression_layer import chunk_sums, marginal, message_moments, shape_posterior

# Widths of the labels: [kg], [m], [kg m^2]; no answer needs to be surer than that.
LABEL_STD = (1e-3,) + (1e-4,) * 3 + (2e-4,) * 6
# Chunks (of REFRESH samples) after which the answer is judged: dense while it is young.
JUDGED = tuple(range(1, 10)) + tuple(range(11, 28, 4)) + tuple(range(29, 100, 5))
# The trapezoidal rule that integrates densities: so many standard deviations to either side, so
# far apart. What both normals leave out there is below what single precision resolves.
REACH, STEP = 8.0, 0.25


def answers(network, shard, prior_mean, prior_std, judged=JUDGED):
    """
    Return mean, variance (B, J, 10) in message order, relative (B, J, 10) after judged chunks.

    relative: stated standard deviation over the prior's, in shape order. network None gives the
    plain regression.
    """
    columns, difference, weights = shard['columns'], shard['difference'], shard['weights']
    last = [(k + 1) * REFRESH - 1 for k in judged]
    shift = spread = None
    if network is not None:
        correction, shift, spread = network(shard['inputs'])
        difference = difference - correction * shard['level'][:, None, :]
        shift, spread = (last_moving(said, shard['moving'])[:, last].double()
                         for said in (shift, spread))
    matrix, vector = chunk_sums(columns, difference, weights, REFRESH)
    picked = list(judged)
    shape, covariance = shape_posterior(
        *marginal(matrix[:, picked].double(), vector[:, picked].double()), prior_mean, prior_std)
    if network is not None:
        shape, covariance = adjusted(shape, covariance, shift, spread)
    std = torch.sqrt(torch.diagonal(covariance, dim1=-2, dim2=-1))
    return *message_moments(shape, covariance), std / prior_std


def last_moving(said, moving):
    """
    Return what was said (B, T, 10) when the arm moved last, nothing before it did (moving (B, T)).

    An arm that stands tells nothing of the load: nor is it any better or worse known.
    """
    steps = torch.arange(1, moving.shape[1] + 1, device=moving.device)
    last = torch.cummax(moving * steps, dim=1).values
    kept = torch.gather(said, 1, (last - 1).clamp(min=0)[..., None].expand_as(said))
    return kept * (last > 0)[..., None]


def adjusted(shape, covariance, shift, spread):
    """Return shape and covariance moved by `shift` deviations and widened by exp(spread)."""
    std = torch.sqrt(torch.diagonal(covariance, dim1=-2, dim2=-1))
    wide = torch.exp(spread)
    return shape + shift * std, covariance * wide[..., None] * wide[..., None, :]


def divergence(mean, variance, load, kind='kl'):
    """
    Return the divergence (B, J, 10) to labels load (B, 10), of a kind of DIVERGENCES.

    The place of a load that weighs nothing has no truth and is left out.
    """
    truth = load[:, None, :].to(mean.dtype)
    width = torch.tensor(LABEL_STD, dtype=mean.dtype, device=mean.device)
    out = DIVERGENCES[kind](mean, variance, truth, width)
    weightless = torch.zeros_like(out, dtype=torch.bool)
    weightless[:, :, 1:4] = (truth[..., :1] < 0.02)
    return torch.where(weightless, torch.zeros_like(out), out)


def kullback_leibler(mean, variance, truth, width):
    """Return KL(N(truth, width^2) || N(mean, variance)) less its constant; shapes that fit."""
    return ((mean - truth) ** 2 + width ** 2) / (2.0 * variance) + 0.5 * torch.log(variance)


def jensen_shannon(mean, variance, truth, width):
    """Return the Jensen-Shannon divergence of N(truth, width^2), N(mean, variance) [nat]."""
    mean, std, truth, width = torch.broadcast_tensors(mean, torch.sqrt(variance), truth, width)
    # It is log 2 but for places that both hold possible: all of those lie within the narrower.
    narrower = torch.minimum(std, width)
    z = torch.arange(-REACH, REACH + STEP, STEP, dtype=mean.dtype, device=mean.device)
    x = torch.where(std < width, mean, truth)[..., None] + narrower[..., None] * z
    ours, label = _log_density(x, mean, std), _log_density(x, truth, width)
    both = (torch.exp(ours) * F.softplus(label - ours)
            + torch.exp(label) * F.softplus(ours - label))
    return math.log(2.0) - 0.5 * STEP * narrower * both.sum(dim=-1)


def _log_density(x, mean, std):
    """Return the logarithm of N(mean, std^2) (...,) at places x (..., K)."""
    mean, std = mean[..., None], std[..., None]
    return -0.5 * ((x - mean) / std) ** 2 - torch.log(std) - 0.5 * math.log(2.0 * math.pi)


DIVERGENCES = {'kl': kullback_leibler, 'jensen_shannon': jensen_shannon}
