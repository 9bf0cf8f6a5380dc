"""Make 95 % mean 95 % on sequences training never saw, and score the network on others."""

import torch

from ..load import MESSAGE_ORDER
from .features import REFRESH
from .objective import JUDGED, answers
from .shards import read_shard

# Chunks (0.1 s each, motion starts 0.15 to 1 s in) whose mass error the card tells.
TOLD = (14, 19, 29, 49, 99)
NORMAL_95 = 1.959964


def _errors(network, paths, prior):
    """
    Return error / std and error (cases, J, 10) after the judged chunks, severe (cases,).

    NaN before the motion starts, and for the place of weightless loads.
    """
    ratios, errors, severe = [], [], []
    ends = torch.tensor([(k + 1) * REFRESH - 1 for k in JUDGED])
    with torch.no_grad():
        for path in paths:
            shard = read_shard(path, 'cpu')
            mean, variance = answers(network, shard, *prior)
            error = mean - shard['load'][:, None, :].double()
            error[ends[None] <= shard['begin'][:, None]] = float('nan')
            error[shard['load'][:, 0] < 0.02, :, 1:4] = float('nan')
            ratios.append(error / torch.sqrt(variance))
            errors.append(error)
            severe.append(shard['severe'] > 0.5)
    return torch.cat(ratios), torch.cat(errors), torch.cat(severe)


def calibrate(network, paths, prior):
    """
    Return factors (10,) on the standard deviations that give 95 % coverage here.

    Here: on arms without an undeclared effect that stands out. With the others counted in, the
    intervals of a healthy arm would be wide for the sake of a sick one.
    """
    ratios, _, severe = _errors(network, paths, prior)
    flat = ratios[~severe].abs().reshape(-1, 10)
    return (torch.nanquantile(flat, 0.95, dim=0) / NORMAL_95).numpy()


def held_out_scores(network, factors, paths, prior):
    """Return coverage and RMSE per parameter, with and without the network, for the card."""
    ratios, errors, severe = _errors(network, paths, prior)
    inside = ratios.abs() < NORMAL_95 * torch.tensor(factors)
    known = torch.isfinite(ratios)
    scores = {}
    for name, cases in (('', ~severe), ('_with_undeclared_effect', severe)):
        coverage = (inside & known)[cases].sum(dim=(0, 1)) / known[cases].sum(dim=(0, 1))
        scores[f'coverage_of_95{name}'] = dict(zip(MESSAGE_ORDER, _rounded(coverage)))
    _, plain, _ = _errors(None, paths, prior)
    for name, values in (('lstm', errors), ('without_network', plain)):
        mass = torch.sqrt((values[:, [JUDGED.index(k) for k in TOLD], 0] ** 2).nanmean(dim=0))
        scores[f'mass_rmse_kg_{name}'] = dict(zip(
            [f'{(k + 1) / 10:g} s' for k in TOLD], _rounded(mass)))
    return scores


def _rounded(tensor):
    return [round(float(v), 4) for v in tensor]
