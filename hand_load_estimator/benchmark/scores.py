"""From the results of all cases to the figures of DESIGN section 6."""

import numpy as np

from ..load import MESSAGE_ORDER
from .measure import MOMENTS

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
    return [r for r in results if len(r['bound']) == len(MOMENTS)]


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
        for k, moment in enumerate(MOMENTS):
            mass = _spread(error[:, k, 0])
            per_time.append({
                'time': moment, 'mass': mass,
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


def verdicts(scores):
    """Return (what, goal, value, reached) of the goals issue 2 states for `lstm`."""
    at = {name: {entry['time']: entry for entry in entries} for name, entries in scores.items()}
    ours, percent = at['lstm'], 'mass_percent_of_rated'
    rivals = [name for name in at if name not in ('bayes', 'fixed rated load')
              and not name.startswith('lstm')]
    rival = min(at[name]['1 s']['mass']['rmse'] for name in rivals)
    rows = [
        ('median mass error at 1 s, % of rated', '<= 1', ours['1 s'][percent]['median'], 1.0),
        ('95th percentile at 1 s, % of rated', '<= 3', ours['1 s'][percent]['p95'], 3.0),
        ('95th percentile at 10 s, % of rated', '<= 0.5', ours['10 s'][percent]['p95'], 0.5)]
    out = [(what, goal, f'{value:.2f}', value <= limit) for what, goal, value, limit in rows]
    ratio = rival / ours['1 s']['mass']['rmse']
    out.append(('better baseline over ours, mass RMSE at 1 s', '>= 4', f'{ratio:.1f}', ratio >= 4))
    shares = np.array([[e['coverage'][m]['share'] for m in MESSAGE_ORDER] for e in ours.values()])
    for what, values in (('coverage of every parameter over all times, %', shares.mean(axis=0)),
                         ('coverage of every parameter at every single time, %', shares)):
        low, high = 100.0 * values.min(), 100.0 * values.max()
        out.append((what, '90 to 99', f'{low:.1f} to {high:.1f}', low >= 90.0 and high <= 99.0))
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
