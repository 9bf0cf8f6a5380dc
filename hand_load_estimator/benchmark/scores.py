"""From the results of all cases to the figures of DESIGN section 6."""

import numpy as np

from ..estimators.registry import METHODS
from ..load import MESSAGE_ORDER
from .contestants import (BLIND, CALIBRATED, DEFAULT, FIXED, ON_FUNCTION, OUR_MODEL, SUBSET,
                          WITHOUT_NETWORK)
from .measure import MOMENTS
from .offline import OFFLINE_TIMES

NORMAL_95 = 1.959964
# Place is scored where there is something to place.
LEAST_MASS_FOR_COM = 2.0
# A moment of inertia is due to be declared where the bound's std is below this share of it.
DUE_MOMENT = 0.05
_MOMENTS_OF_INERTIA = (4, 7, 9)


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


def _widths(std, bound):
    """Return {parameter: median} of stds over a bound's, (cases, 10) each."""
    return dict(zip(MESSAGE_ORDER, np.median(std / bound, axis=0).tolist()))


def _clustered(inside, plants):
    """Return the mean of booleans (cases,) and its standard error over plants."""
    means = np.array([inside[plants == p].mean() for p in np.unique(plants)])
    error = means.std(ddof=1) / np.sqrt(len(means)) if len(means) > 1 else float('nan')
    return {'share': float(inside.mean()), 'error': float(error)}


def score(results, rated_mass):
    """
    Return {method: figures} of complete cases; masses in kg, lengths in m.

    start_unknown: what the bound is, and the width over it, with friction's start unknown.
    """
    results = complete(results)
    start_unknown = np.array([r['bound_start_unknown'] for r in results])
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
                'bound_mass_rmse': _spread(bound[:, k, 0])['rmse'],
                'coverage': {m: _clustered(inside[:, k, i], plants)
                             for i, m in enumerate(MESSAGE_ORDER)},
                'width_over_bound': _widths(std[:, k], bound[:, k]),
                'start_unknown': {
                    'bound_mass_rmse': _spread(start_unknown[:, k, 0])['rmse'],
                    'width_over_bound': _widths(std[:, k], start_unknown[:, k])}})
        out[name] = per_time
    return out


def rivals_of(scores):
    """Return the names of the baselines that estimate: not ours, not the fixed load."""
    return [name for name in scores
            if name not in METHODS
            and name not in (BLIND, FIXED, OUR_MODEL, SUBSET, *ON_FUNCTION)
            and not name.endswith(CALIBRATED)]


def network_shares(scores):
    """
    Return what the default's network takes off the error [%] of mass and place at each time.

    Empty where default and update without network do not both take part.
    """
    if DEFAULT not in scores or WITHOUT_NETWORK not in scores or DEFAULT == WITHOUT_NETWORK:
        return []
    out = []
    for ours, without in zip(scores[DEFAULT], scores[WITHOUT_NETWORK]):
        pairs = ((ours['mass']['rmse'], without['mass']['rmse']),
                 (ours['com']['median'], without['com']['median']))
        mass, com = (100.0 * (1.0 - a / b) if b else 0.0 for a, b in pairs)
        out.append({'time': ours['time'], 'mass': mass, 'com': com})
    return out


def inertia_scores(results):
    """
    Return {method: figures} of the moments ixx, iyy, izz at the end of complete cases.

    due: those whose bound's std is below DUE_MOMENT of the truth; declared: the share of them
    with std below the method's threshold; median_error [%] of those; declared_beyond: how many
    were declared without being due.
    """
    results = [r for r in complete(results) if 'determined_below' in r]
    out = {}
    for name in results[0]['methods'] if results else ():
        error, std, bound = (x[:, -1, _MOMENTS_OF_INERTIA] for x in _matrix(results, name))
        truth = np.array([r['load'] for r in results])[:, _MOMENTS_OF_INERTIA]
        below = np.array([r['determined_below'] for r in results])[:, _MOMENTS_OF_INERTIA]
        due, declared = bound < DUE_MOMENT * truth, std < below
        if name == FIXED or not due.any():
            continue
        both = due & declared
        relative = 100.0 * np.abs(error[both]) / truth[both]
        out[name] = {'due': int(due.sum()), 'declared': float(declared[due].mean()),
                     'median_error': float(np.median(relative)) if both.any() else float('nan'),
                     'declared_beyond': int((declared & ~due).sum())}
    return out


def offline_scores(results):
    """
    Return mass RMSE [kg] and median distance [m] of offline rivals, and ours on the same cases.

    {'cases': n, 'methods': {name: {moment: {'mass', 'com', 'cases'}}}}, or {} without any.
    """
    results = [r for r in complete(results) if r.get('offline')]
    if not results:
        return {}
    out = {}
    for name in results[0]['offline']:
        out[name] = {m: _of_means(results, [r['offline'][name][m] for r in results])
                     for m in OFFLINE_TIMES}
    for name in results[0]['methods']:
        out[name] = {m: _of_means(results, [r['methods'][name][MOMENTS.index(m)]
                                            for r in results]) for m in OFFLINE_TIMES}
    return {'cases': len(results), 'methods': out}


def _of_means(results, rows):
    """Return the figures of rows [mean, std]; a sentence in place of one is a failure."""
    found = [(np.array(row[0]) - r['load'], r['load'][0]) for r, row in zip(results, rows)
             if not isinstance(row, str)]
    if not found:
        return {'mass': float('nan'), 'com': float('nan'), 'cases': 0}
    errors, heavy = np.array([e for e, _ in found]), [m >= LEAST_MASS_FOR_COM for _, m in found]
    place = np.linalg.norm(errors[heavy][:, 1:4], axis=1)
    return {'mass': float(np.sqrt(np.mean(errors[:, 0] ** 2))),
            'com': float(np.median(place)) if len(place) else float('nan'),
            'cases': len(found)}


def verdicts(scores):
    """Return (what, goal, value, reached) of the goals issue 2 states for the default."""
    at = {name: {entry['time']: entry for entry in entries} for name, entries in scores.items()}
    ours, percent = at[DEFAULT], 'mass_percent_of_rated'
    rival = min(at[name]['1 s']['mass']['rmse'] for name in rivals_of(at))
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
    out = {'cases': len(results), 'scored': len(done),
           'plants': len({r['plant'] for r in results}),
           'false_load_changes': int(sum(r['changes'] > 0 for r in results)),
           'microseconds_per_sample': {
               name: float(1e6 * np.median([r['seconds_per_sample'][name] for r in results]))
               for name in results[0]['seconds_per_sample']}}
    if 'cost' in results[0]:
        out['changes_of'] = {name: int(sum(r['changes_of'][name] > 0 for r in results))
                             for name in results[0]['changes_of']}
        out['mismatch'] = {name: float(np.mean([r['mismatch'][name] for r in results]))
                           for name in results[0]['mismatch']}
        out['cost'] = {name: {key: float(np.median([r['cost'][name][key] for r in results]))
                              for key in ('mean', 'p50', 'p99')}
                       for name in results[0]['cost']}
    return out
