"""The undeclared suite effect by effect: the mean over all effects hides which one does harm."""

import numpy as np

from .document import Heading, Table, Text
from .measure import MOMENTS
from .scores import complete, NORMAL_95

_SHOWN = ('0.5 s', '1 s', '10 s')


def hidden_scores(results, name):
    """
    Return {effect: figures} of a method on complete cases with one hidden effect each.

    cases, plants; mass_rmse [kg] by moment; coverage: share of 95 % intervals that hold the
    truth, over all parameters and times; lowest: that of the parameter with the lowest one;
    mismatch: share of the time in which the method said that model and torques do not fit.
    """
    own = {}
    for result in complete(results):
        own.setdefault(result['hidden'][0], []).append(result)
    return {effect: _figures(own[effect], name) for effect in sorted(own)}


def _figures(results, name):
    truth = np.array([r['load'] for r in results])
    values = np.array([r['methods'][name] for r in results])
    error = values[:, :, 0] - truth[:, None]
    inside = np.abs(error) <= NORMAL_95 * values[:, :, 1]
    rmse = np.sqrt(np.mean(error[:, :, 0] ** 2, axis=0))
    return {'cases': len(results), 'plants': len({r['plant'] for r in results}),
            'mass_rmse': dict(zip(MOMENTS, rmse.tolist())),
            'coverage': float(inside.mean()), 'lowest': float(inside.mean(axis=(0, 1)).min()),
            'mismatch': float(np.mean([r['mismatch'][name] for r in results]))}


def hidden_blocks(found, name):
    """Return the blocks of hidden_scores of a method; none without any."""
    if not found:
        return []
    rows = [[effect, f'{f["cases"]} of {f["plants"]}',
             *(f'{1e3 * f["mass_rmse"][moment]:.0f}' for moment in _SHOWN),
             f'{100.0 * f["coverage"]:.1f}', f'{100.0 * f["lowest"]:.0f}',
             f'{100.0 * f["mismatch"]:.1f}'] for effect, f in found.items()]
    return [Heading(f'`{name}`, effect by effect'), Text(
        'Few cases of each: what stands out here is worth a look, and no more than that. Coverage '
        'is over all parameters and times; lowest is the parameter with the lowest one.'),
        Table(['hidden effect', 'cases of plants', *(f'mass RMSE, {m} [g]' for m in _SHOWN),
               'coverage of 95 % [%]', 'lowest [%]', 'MODEL_MISMATCH [%]'], rows)]
