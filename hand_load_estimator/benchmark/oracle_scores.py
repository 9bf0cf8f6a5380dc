"""The undeclared suite beside an oracle: whose errors are the effect's, and whose the method's."""

import numpy as np

from .document import Heading, Table, Text
from .measure import MOMENTS
from .scores import complete, NORMAL_95

ALL = 'all'
_SHOWN = ('1 s', '10 s')
_MEANING = (
    'An oracle knows torque model, friction state and noise exactly, but of the effect nothing '
    '(benchmark/oracle.py). Share: what a load makes of the torque that the effect adds along the '
    'true motion, of its weighted square over moving joints, median of the cases; by chance: the '
    'same of that torque at other times of the run. Rest: what no load makes, over what the model '
    'leaves of the arm without the effect, in the joint that shows it most. Joints free: every '
    "joint's offset, Coulomb and viscous friction may be anything. Bound: no estimator that "
    "leaves out standing joints, as the oracle does, is better, even if it knows the shape of the "
    "effect's torque and only its size not. Coverage of "
    "the oracle: of its errors by the method's intervals. `-`: the effect did not act in these "
    'runs.')
_TOLD = (
    "**Where the share is near 100 %, and the bound as wide as the oracle's error, no estimator "
    'can tell the effect from a load without a motion without load.** Where the bound stays at '
    'grams the torques do tell, to one who knows the arm exactly and what to look for; the '
    "oracle's error is then what it costs not to look, however well the arm was known before, and "
    'a method that doubts its model may err less.')


def oracle_scores(results, name):
    """
    Return {effect: figures} of a method on complete cases with one hidden effect each; and ALL.

    cases; share, chance, rest: medians of Likeness over the cases; mass_rmse {who: {moment:
    [kg]}}, who: method, oracle, free (oracle with free joints), bound; mass_coverage {who: share
    over the moments} of method and oracle, by the method's intervals.
    """
    own = {}
    for result in complete(results):
        own.setdefault(result['hidden'][0], []).append(result)
    groups = {effect: own[effect] for effect in sorted(own)}
    return {effect: _figures(group, name) for effect, group in {
        **groups, ALL: [result for group in groups.values() for result in group]}.items()}


def _figures(results, name):
    told = [result['oracle'] for result in results]
    values = np.array([result['methods'][name] for result in results])[:, :, :, 0]
    errors = {'method': values[:, :, 0] - np.array([[r['load'][0]] for r in results]),
              'oracle': np.array([one['mass'] for one in told]),
              'free': np.array([one['mass_free'] for one in told]),
              'bound': np.array([one['mass_bound'] for one in told])}
    return {
        'cases': len(results), **{key: _median(told, key) for key in ('share', 'chance', 'rest')},
        'mass_rmse': {who: dict(zip(MOMENTS, np.sqrt(np.mean(error ** 2, axis=0)).tolist()))
                      for who, error in errors.items()},
        'mass_coverage': {
            who: float(np.mean(np.abs(errors[who]) <= NORMAL_95 * values[:, :, 1]))
            for who in ('method', 'oracle')}}


def _median(told, key):
    known = [one[key] for one in told if np.isfinite(one[key])]
    return float(np.median(known)) if known else float('nan')


def oracle_blocks(found, name):
    """Return the blocks of oracle_scores of a method; none without any."""
    if not found:
        return []
    who = (f'`{name}`', 'oracle', 'oracle, joints free')
    times = f'{" / ".join(_SHOWN)} [g]'
    head = ['hidden effect', 'share a load makes [%]', 'by chance [%]', 'rest [-]',
            *(f'mass RMSE, {one}, {times}' for one in who), f'bound of the mass, {times}',
            *(f'coverage of the mass, {one} [%]' for one in who[:2])]
    rows = [[effect, _percent(f['share']), _percent(f['chance']), _number(f['rest'], '.2f'),
             *(' / '.join(f'{1e3 * errors[moment]:.0f}' for moment in _SHOWN)
               for errors in f['mass_rmse'].values()),
             *(_percent(share) for share in f['mass_coverage'].values())]
            for effect, f in found.items()]
    return [Heading(f'`{name}` beside an oracle without the effect'), Text(_MEANING),
            Text(_TOLD), Table(head, rows)]


def _percent(share):
    return _number(100.0 * share, '.0f')


def _number(value, form):
    return format(value, form) if np.isfinite(value) else '-'
