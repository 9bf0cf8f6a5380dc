"""The result page: Markdown tables and one picture."""

import numpy as np

from ..load import MESSAGE_ORDER
from .measure import TIMES


def _row(cells):
    return '| ' + ' | '.join(cells) + ' |'


def _table(head, rows):
    return '\n'.join([_row(head), _row(['---'] * len(head)), *map(_row, rows)])


def _mass_table(scores):
    times = [entry['time'] for entry in next(iter(scores.values()))]
    rows = [[name, *(f'{1e3 * entry["mass"]["rmse"]:.0f}' for entry in entries)]
            for name, entries in scores.items()]
    ours = scores['lstm']
    rows.append(['Cramer-Rao bound', *(f'{1e3 * e["bound_mass_rmse"]:.1f}' for e in ours)])
    rows.append(['`lstm` over the bound', *(
        f'{e["mass"]["rmse"] / e["bound_mass_rmse"]:.1f}' for e in ours)])
    return _table(['mass RMSE [g] after', *times], rows)


def _percent_table(scores):
    times = [entry['time'] for entry in next(iter(scores.values()))]
    rows = [[name, *(' / '.join(f'{e["mass_percent_of_rated"][f]:.2f}' for f in ('median', 'p95'))
                     for e in entries)] for name, entries in scores.items()]
    return _table(['mass, median / 95th percentile [% of rated] after', *times], rows)


def _inertia_table(entries):
    rows = [[e['time'], *(f'{1e3 * e["inertia"][m]["median"]:.1f}' for m in MESSAGE_ORDER[4:])]
            for e in entries]
    return _table(['inertia, median error [g m^2]', *MESSAGE_ORDER[4:]], rows)


def _com_table(scores):
    times = [entry['time'] for entry in next(iter(scores.values()))]
    rows = [[name, *(f'{1e3 * e["com"]["median"]:.1f} / {1e3 * e["com"]["p95"]:.1f}'
                     for e in entries)] for name, entries in scores.items()]
    return _table(['centre of mass, median / 95th percentile [mm] after',
                   *times], rows)


def _coverage_table(entries):
    rows = [[e["time"], *(f'{100 * e["coverage"][m]["share"]:.1f} '
                          f'({100 * e["coverage"][m]["error"]:.1f})'
                          for m in MESSAGE_ORDER)] for e in entries]
    return _table(['coverage of 95 % (standard error over plants) [%]', *MESSAGE_ORDER], rows)


def _width_table(entries):
    rows = [[e["time"], *(f'{e["width_over_bound"][m]:.1f}' for m in MESSAGE_ORDER)]
            for e in entries]
    return _table(['width over bound', *MESSAGE_ORDER], rows)


def markdown(scores, overview, verdicts, command, commit):
    """Return the page as text."""
    parts = [
        '# Accuracy on the base suite',
        f'{overview["scored"]} of {overview["cases"]} cases from {overview["plants"]} plants that '
        'training never saw. Every plant has its own model, '
        'identified from four 40 s recordings without load. '
        f'False load changes: {overview["false_load_changes"]} cases.',
        f'Command: `{command}`, commit {commit}.',
        _table(['goal', 'wanted', 'measured', 'reached'], [
            [what, goal, value, 'yes' if good else '**no**'] for what, goal, value, good
            in verdicts]),
        _mass_table(scores), _percent_table(scores), _com_table(scores),
        _inertia_table(scores['lstm'])]
    for name in ('lstm', 'bayes'):
        if name in scores:
            parts += [f'## Intervals of `{name}`', _coverage_table(scores[name]),
                      _width_table(scores[name])]
    cost = overview['microseconds_per_sample']
    parts += ['## Cost', _table(['method', 'microseconds per 20 ms sample'],
                                [[name, f'{value:.0f}'] for name, value in cost.items()])]
    return '\n\n'.join(parts) + '\n'


def picture(scores, path):
    """Draw mass RMSE over time for every method and the bound."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(7.0, 5.5), layout='constrained')
    for name, entries in scores.items():
        axes.loglog(TIMES, [1e3 * e['mass']['rmse'] for e in entries[:len(TIMES)]], 'o-',
                    label=name)
    bound = [1e3 * e['bound_mass_rmse'] for e in entries[:len(TIMES)]]
    axes.loglog(TIMES, bound, 'k--', label='Cramer-Rao bound')
    axes.set(xlabel='time after motion start [s]', ylabel='mass RMSE [g]')
    axes.set_xticks(TIMES, [f'{t:g}' for t in TIMES])
    axes.set_xticks([], minor=True)
    axes.set_ylim(1.0, 1.2e3 * np.max([e['mass']['rmse'] for v in scores.values() for e in v]))
    axes.grid(True, which='major', alpha=0.4)
    figure.legend(loc='outside lower center', ncols=2, fontsize='small')
    figure.savefig(path, dpi=130)
    pyplot.close(figure)
