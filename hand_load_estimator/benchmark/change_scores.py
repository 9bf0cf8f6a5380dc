"""From the runs of the changes suite to its figures: seen in time, rightly, and only once."""

import numpy as np

from .changes import KINDS
from .scores import LEAST_MASS_FOR_COM, NORMAL_95

# A change is seen rightly where the estimate at the end is within so many standard deviations of
# the load held then, or within this share of the rated mass and this distance [m].
SIGMAS, MASS_SHARE, DISTANCE = 3.0, 0.02, 0.003


def change_scores(results):
    """
    Return {'overview': counts, 'known', 'methods': {name: figures}} of results by label.

    known: delays [s] of a test that knows both loads, median and 95th percentile. Figures:
    changes; missed (not seen until the end of the run, or seen and the load at the end is another
    one: wrong counts these); too_early (runs in which one was seen before it happened); extra
    (counts beyond the first after the change); delays [s] after the first motion that could tell,
    by kind too; false_alarms in hours of running, mass_rmse [kg] and inside (share within the
    95 % interval) at the end of these.
    """
    changed = [r for label, r in results.items() if label.startswith('change_')]
    running = [r for label, r in results.items() if label.startswith('running_')]
    counts = {'cases': len(changed), 'plants': len({r['plant'] for r in changed})}
    changed = [r for r in changed if r['moved'] is not None]
    names = {name for r in changed for name in r['seen']} \
        | {name for r in running for name in r['changes']}
    known = [max(r['earliest'] - r['moved'], 0.0) for r in changed if r['earliest'] is not None]
    return {'overview': {**counts, 'scored': len(changed)}, 'known': _quantiles(known),
            'methods': {name: {**_of_changes(name, changed), **_of_running(name, running)}
                        for name in sorted(names)}}


def _after(name, result):
    """Return the stamps [s] of the changes counted after the load changed."""
    return [stamp for stamp in result['seen'][name] if stamp >= result['at']]


def found_load(name, result):
    """Tell whether the estimate at the end of a run is of the load held then."""
    truth, (mean, std) = np.array(result['load']), np.array(result['end'][name])
    allowed = np.maximum(SIGMAS * std[:4], [MASS_SHARE * result['rated'], *[DISTANCE] * 3])
    right = np.abs(mean - truth)[:4] <= allowed
    return bool(right.all() if truth[0] >= LEAST_MASS_FOR_COM else right[0])


def _delay(name, result):
    """Return the delay [s] until the first count of a change that was seen rightly, or None."""
    after = _after(name, result)
    if not after or not found_load(name, result):
        return None
    return max(after[0] - result['moved'], 0.0)


def _of_changes(name, changed):
    delays = [_delay(name, r) for r in changed]
    seen = np.array([d for d in delays if d is not None])
    kinds = {}
    for kind in KINDS:
        own = [d for d, r in zip(delays, changed) if r['kind'] == kind]
        found = [d for d in own if d is not None]
        kinds[kind] = {'changes': len(own), 'missed': len(own) - len(found),
                       'delay_median': float(np.median(found)) if found else float('nan'),
                       'delay_longest': max(found, default=float('nan'))}
    return {'changes': len(delays), 'missed': sum(d is None for d in delays),
            'wrong': sum(bool(_after(name, r)) and not found_load(name, r) for r in changed),
            'too_early': sum(any(s < r['at'] for s in r['seen'][name]) for r in changed),
            'extra': sum(max(len(_after(name, r)) - 1, 0) for r in changed),
            **_quantiles(seen), 'delays': seen.tolist(), 'kinds': kinds}


def _quantiles(delays):
    return {'delay_median': float(np.median(delays)) if len(delays) else float('nan'),
            'delay_p95': float(np.quantile(delays, 0.95)) if len(delays) else float('nan')}


def _of_running(name, running):
    error, std = np.array([r['end'][name] for r in running]).reshape(-1, 2).T
    return {'false_alarms': int(sum(r['changes'].get(name, 0) for r in running)),
            'hours': float(sum(r['seconds'] for r in running) / 3600.0),
            'mismatch': _mean([r['mismatch'][name] for r in running]),
            'mass_rmse': float(np.sqrt(_mean(error ** 2))),
            'inside': _mean(np.abs(error) <= NORMAL_95 * std)}


def _mean(values):
    return float(np.mean(values)) if len(values) else float('nan')
