"""From the results of all cases to the figures of DESIGN section 6."""

import numpy as np

from ..load import MESSAGE_ORDER
from .measure import TIMES

NORMAL_95 = 1.959964
# Place is scored where there is something to place.
LEAST_MASS_FOR_COM = 2.0


def _matrix(results, name):
    """Return error, std, bound (cases, times, 10) of a method over complete cases."""
    truth = np.array([r['load'] for r in results])
    values = np.array([r['methods'][name] for r in results])
    bound = np.array([r['bound'] for r in results])
    return values[:, :, 0] - truth[:, None], values[:, :, 1], bound


def complete(results):
    """Return the cases in which the arm moved long enough for every time."""
    return [r for r in results if len(r['bound']) == len(TIMES)]


def _spread(values):
    """Return RMSE, median and 95th percentile of absolute errors (cases,)."""
    return {'rmse': float(np.sqrt(np.mean(values ** 2))),
            'median': float(np.median(np.abs(values))),
            'p95': float(np.quantile(np.abs(values), 0.95))}


def _clustered(inside, plants):
    """Return the mean of booleans (cases,) and its standard error over plants."""
    means = np.array([inside[plants == p].mean() for p in np.unique(plants)])
    error = means.std(ddof=1) / np.sqrt(len(means)) if len(means) > 1 else float('nan')
    return {'share': float(inside.mean()), 'error': float(error)}


def score(results, rated_mass):
    """Return {method: figures} of complete cases; masses in kg, lengths in m."""
    results = complete(results)
    plants = np.array([r['plant'] for r in results])
    heavy = np.array([r['load'][0] >= LEAST_MASS_FOR_COM for r in results])
    out = {}
    for name in results[0]['methods']:
        error, std, bound = _matrix(results, name)
        com = np.linalg.norm(error[heavy][:, :, 1:4], axis=2)
        inside = np.abs(error) <= NORMAL_95 * std
        per_time = []
        for k, t in enumerate(TIMES):
            mass = _spread(error[:, k, 0])
            per_time.append({
                'time': t, 'mass': mass,
                'mass_percent_of_rated': {n: 100.0 * v / rated_mass for n, v in mass.items()},
                'com': _spread(com[:, k]),
                'inertia': {m: _spread(error[:, k, i]) for i, m in
                            enumerate(MESSAGE_ORDER) if i >= 4},
                'bound_mass_rmse': float(np.sqrt(np.mean(bound[:, k, 0] ** 2))),
                'coverage': {m: _clustered(inside[:, k, i], plants)
                             for i, m in enumerate(MESSAGE_ORDER)},
                'width_over_bound': {m: float(np.median(std[:, k, i] / bound[:, k, i]))
                                     for i, m in enumerate(MESSAGE_ORDER)}})
        out[name] = per_time
    return out


def overview(results):
    """Return counts and costs over all cases."""
    done = complete(results)
    return {'cases': len(results), 'scored': len(done),
            'plants': len({r['plant'] for r in results}),
            'false_load_changes': int(sum(r['changes'] > 0 for r in results)),
            'microseconds_per_sample': {
                name: float(1e6 * np.median([r['seconds_per_sample'][name] for r in results]))
                for name in results[0]['seconds_per_sample']}}
