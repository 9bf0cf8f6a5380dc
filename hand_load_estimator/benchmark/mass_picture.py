"""The picture of an accuracy suite: mass error over time, a colour for each kind of method."""

import numpy as np

from ..learning.direct_design import NETWORKS
from .contestants import BLIND, DEFAULT, FIXED, FUNCTION, OUR_MODEL, SUBSET
from .document import Picture
from .measure import TIMES
from .scores import rivals_of

# What stands behind a bound's name, or a ratio to it, that does not know what friction was.
START_UNKNOWN = "friction's start unknown"
# Twenty lines in one colour each could not be told apart: members of a kind differ by their mark.
_OURS, _FUNCTIONS, _DIRECT, _BASELINES = 'tab:blue', 'tab:green', 'tab:gray', 'tab:orange'
_MARKS = 'osD^v<>P'


def mass_picture(scores):
    """Return the Picture of mass RMSE over time for every method and the bounds."""
    return Picture('mass', lambda figure: _draw(figure, scores),
                   'mass RMSE over time after motion start', 6.0)


def _kind(name, baselines):
    if name in FUNCTION:
        return _FUNCTIONS
    if name in NETWORKS or name == SUBSET:
        return _DIRECT
    return _BASELINES if name in baselines else _OURS


def _draw(figure, scores):
    axes, seen, baselines = figure.subplots(), {}, (*rivals_of(scores), FIXED, OUR_MODEL)
    for name, entries in scores.items():
        kind = _kind(name, baselines)
        mark = _MARKS[seen.get(kind, 0) % len(_MARKS)]
        seen[kind] = seen.get(kind, 0) + 1
        first = name == DEFAULT
        axes.loglog(TIMES, [1e3 * e['mass']['rmse'] for e in entries[:len(TIMES)]], label=name,
                    marker=mark, linestyle='--' if name == BLIND else '-', color=kind,
                    linewidth=3.0 if first else 1.0, zorder=3.0 if first else 2.0,
                    markerfacecolor=kind if first else 'white')
    for label, line, found in (('Cramer-Rao bound', 'k:', entries), (
            f'bound, {START_UNKNOWN}', 'k-.', [e['start_unknown'] for e in entries])):
        axes.loglog(TIMES, [1e3 * e['bound_mass_rmse'] for e in found[:len(TIMES)]], line,
                    label=label)
    axes.set(xlabel='time after motion start [s]', ylabel='mass RMSE [g]')
    axes.set_xticks(TIMES, [f'{t:g}' for t in TIMES])
    axes.set_xticks([], minor=True)
    axes.set_ylim(1.0, 1.2e3 * np.max([e['mass']['rmse'] for v in scores.values() for e in v]))
    axes.grid(True, which='major', alpha=0.4)
    figure.legend(loc='outside lower center', ncols=2, fontsize='small')
