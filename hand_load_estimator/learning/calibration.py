"""Make 95 % mean 95 % on sequences training never saw, and score the network on others."""

import numpy as np
import torch

from ..load import MESSAGE_ORDER
from .features import REFRESH
from .interval_factors import LEVELS
from .objective import JUDGED, answers
from .shards import read_shard

# Chunks (0.1 s each, motion starts 0.15 to 1 s in) whose mass error the card tells.
TOLD = (9, 19, 29, 49, 99)
NORMAL_95 = 1.959964
# Answers within this of a level [decades] tell its factor; fewer than LEAST tell nothing sure,
# and then the nearest LEAST of all answers do.
NEAR, LEAST = 0.2, 1500


def _errors(network, paths, prior):
    """
    Return error / std, error, level (cases, J, 10) after the judged chunks, severe (cases,).

    NaN before the motion starts, and for the place of weightless loads. level: as of level_of.
    """
    ratios, errors, levels, severe = [], [], [], []
    ends = torch.tensor([(k + 1) * REFRESH - 1 for k in JUDGED])
    with torch.no_grad():
        for path in paths:
            shard = read_shard(path, 'cpu')
            mean, variance, relative = answers(network, shard, *prior)
            error = mean - shard['load'][:, None, :].double()
            error[ends[None] <= shard['begin'][:, None]] = float('nan')
            error[shard['load'][:, 0] < 0.02, :, 1:4] = float('nan')
            ratios.append(error / torch.sqrt(variance))
            errors.append(error)
            levels.append(torch.log10(relative))
            severe.append(shard['severe'] > 0.5)
    return (*(torch.cat(x).numpy() for x in (ratios, errors, levels)),
            torch.cat(severe).numpy())


def calibrate(network, paths, prior):
    """
    Return factors (10, levels) on the standard deviations that give 95 % coverage here.

    Here: on arms without an undeclared effect that stands out. With the others counted in, the
    intervals of a healthy arm would be wide for the sake of a sick one.
    """
    ratios, _, levels, severe = _errors(network, paths, prior)
    ratios, levels = (x[~severe].reshape(-1, 10).T for x in (np.abs(ratios), levels))
    return np.array([[_factor(ratio, level, at) for at in LEVELS]
                     for ratio, level in zip(ratios, levels)])


def _factor(ratio, level, at):
    """Return the factor at a level from |error| / std and levels (answers,) of a parameter."""
    known = np.isfinite(ratio)
    ratio, away = ratio[known], np.abs(level[known] - at)
    reach = max(NEAR, np.sort(away)[min(LEAST, len(away)) - 1])
    return np.quantile(ratio[away <= reach], 0.95) / NORMAL_95


def held_out_scores(network, factors, paths, prior):
    """
    Return coverage per parameter and mass RMSE, with and without the network, for the card.

    Coverage of arms without and with an undeclared effect, left out where there is no such arm.
    """
    ratios, errors, levels, severe = _errors(network, paths, prior)
    wide = np.stack([np.interp(levels[..., k], LEVELS, factors[k]) for k in range(10)], axis=-1)
    inside, known = np.abs(ratios) < NORMAL_95 * wide, np.isfinite(ratios)
    scores = {}
    for name, cases in (('', ~severe), ('_with_undeclared_effect', severe)):
        if not cases.any():
            continue
        coverage = (inside & known)[cases].sum(axis=(0, 1)) / known[cases].sum(axis=(0, 1))
        scores[f'coverage_of_95{name}'] = dict(zip(MESSAGE_ORDER, _rounded(coverage)))
    plain = _errors(None, paths, prior)[1]
    for name, values in (('lstm', errors), ('without_network', plain)):
        squares = values[:, [JUDGED.index(k) for k in TOLD], 0] ** 2
        scores[f'mass_rmse_kg_{name}'] = dict(zip(
            [f'{(k + 1) / 10:g} s' for k in TOLD], _rounded(np.sqrt(np.nanmean(squares, axis=0)))))
    return scores


def _rounded(values):
    return [round(float(v), 4) for v in values]
