"""The page of an accuracy suite: tables and pictures of what was measured."""

import numpy as np

from ..load import MESSAGE_ORDER
from .contestants import DEFAULT, FIXED, OUR_MODEL, REGRESSOR, WITHOUT_NETWORK
from .document import Heading, Table, Text
from .hidden_scores import hidden_blocks
from .mass_picture import mass_picture, START_UNKNOWN
from .oracle_scores import oracle_blocks
from .scores import rivals_of


def leading(scores):
    """Return the method the page is about: the default, or the first where it has no place."""
    return DEFAULT if DEFAULT in scores else next(iter(scores))


def _times(scores):
    return [entry['time'] for entry in next(iter(scores.values()))]


def _mass_table(scores):
    rows = [[name, *(_in_grams(entry['mass']['rmse']) for entry in entries)]
            for name, entries in scores.items()]
    name = leading(scores)
    ours = scores[name]
    bounds = {'': [e['bound_mass_rmse'] for e in ours],
              f', {START_UNKNOWN}': [e['start_unknown']['bound_mass_rmse'] for e in ours]}
    rows += [[f'Cramer-Rao bound{which}', *(f'{1e3 * value:.1f}' for value in bound)]
             for which, bound in bounds.items()]
    rows += [[f'`{name}` over the bound{which}', *(
        f'{e["mass"]["rmse"] / value:.1f}' for e, value in zip(ours, bound))]
             for which, bound in bounds.items()]
    return Table(['mass RMSE [g] after', *_times(scores)], rows)


def _in_grams(mass):
    # Whole grams of a small mass would hide what cold is over warm, or one method over another.
    return f'{1e3 * mass:.{1 if mass < 0.02 else 0}f}'


def _percent_table(scores):
    rows = [[name, *(' / '.join(f'{e["mass_percent_of_rated"][f]:.2f}' for f in ('median', 'p95'))
                     for e in entries)] for name, entries in scores.items()]
    return Table(['mass, median / 95th percentile [% of rated] after', *_times(scores)], rows)


def _inertia_table(entries):
    rows = [[e['time'], *(f'{1e3 * e["inertia"][m]["median"]:.1f}' for m in MESSAGE_ORDER[4:])]
            for e in entries]
    return Table(['inertia, median error [g m^2]', *MESSAGE_ORDER[4:]], rows)


def _com_table(scores):
    rows = [[name, *(f'{1e3 * e["com"]["median"]:.1f} / {1e3 * e["com"]["p95"]:.1f}'
                     for e in entries)] for name, entries in scores.items()]
    return Table(['centre of mass, median / 95th percentile [mm] after', *_times(scores)], rows)


def _coverage_table(entries):
    rows = [[e['time'], *(_covered(e['coverage'][m]) for m in MESSAGE_ORDER)] for e in entries]
    return Table(['coverage of 95 % (standard error over plants) [%]', *MESSAGE_ORDER], rows)


def _covered(figures):
    share, error = 100.0 * figures['share'], 100.0 * figures['error']
    return f'{share:.1f} ({error:.1f})' if np.isfinite(error) else f'{share:.1f}'


def _width_tables(entries):
    widths = {'': [e['width_over_bound'] for e in entries],
              f', {START_UNKNOWN}': [e['start_unknown']['width_over_bound'] for e in entries]}
    return [Table([f'width over bound{which}', *MESSAGE_ORDER], [
        [e['time'], *(f'{width[m]:.1f}' for m in MESSAGE_ORDER)]
        for e, width in zip(entries, found)]) for which, found in widths.items()]


def _all_coverage_table(scores):
    """Return one row per method of ours: coverage over all times, of all parameters and each."""
    rows = []
    for name in scores:
        if name in (*rivals_of(scores), FIXED, OUR_MODEL):
            continue
        shares = {m: 100.0 * float(np.mean([e['coverage'][m]['share'] for e in scores[name]]))
                  for m in MESSAGE_ORDER}
        low, high = (choose(shares, key=shares.get) for choose in (min, max))
        rows.append([name, f'{np.mean(list(shares.values())):.1f}',
                     f'{shares[low]:.1f} ({low})', f'{shares[high]:.1f} ({high})'])
    return Table(['coverage of 95 % over all times [%]', 'all parameters', 'lowest', 'highest'],
                 rows)


def _interval_blocks(scores):
    """Return the intervals of ours; the baselines' are no claim of anybody's."""
    out = [Heading('Intervals'), _all_coverage_table(scores)]
    for name in scores:
        if name in (DEFAULT, WITHOUT_NETWORK):
            out += [Heading(f'Intervals of `{name}`'), _coverage_table(scores[name]),
                    *_width_tables(scores[name])]
    return out


def _network_blocks(shares):
    """Return what the default's network adds to the update without it, said plainly."""
    if not shares:
        return []
    head = [f'`{WITHOUT_NETWORK}` to `{DEFAULT}`: error less by [%] after',
            *(share['time'] for share in shares)]
    rows = [[what, *(f'{share[key]:.0f}' for share in shares)]
            for what, key in (('mass RMSE', 'mass'), ('centre of mass, median', 'com'))]
    least = [share['time'] for share in shares if share['mass'] < 20.0]
    said = (f'The network gains less than 20 % in mass at: {", ".join(least)}.' if least
            else 'The network gains 20 % or more in mass at every time.')
    return [Heading("The network's own share"), Table(head, rows), Text(f'**{said}**')]


def _determined_blocks(inertia):
    if not inertia:
        return []
    rows = [[name, str(e['due']), f'{100 * e["declared"]:.0f}',
             f'{e["median_error"]:.1f}' if np.isfinite(e['median_error']) else '-',
             str(e['declared_beyond'])] for name, e in inertia.items()]
    return [Heading('Moments of inertia at the end of the run'), Table(
        ['method', 'moments whose bound is below 5 %', 'declared determined [%]',
         'median error of those [%]', 'declared although the bound is above 5 %'], rows)]


def _offline_blocks(offline):
    if not offline:
        return []
    times = next(iter(offline['methods'].values()))
    rows = [[name, *(_grams(entry) for entry in entries.values())]
            for name, entries in offline['methods'].items()]
    return [Heading('Rivals that look at the whole recording'), Text(
        f'{offline["cases"]} of the cases (the first of each plant): mass RMSE [g] / median '
        'distance of the centre of mass [mm], in brackets how many of the cases gave a result. '
        'How each was used: benchmark/rival_mujoco.py, rival_figaroh.py; both see the torque that '
        'the identified model with Coulomb and viscous friction leaves, without standing joints.'),
        Table(['method', *times], rows)]


def _grams(entry):
    if not entry['cases']:
        return '- (0)'
    return f'{1e3 * entry["mass"]:.0f} / {1e3 * entry["com"]:.1f} ({entry["cases"]})'


def _trust_table(counts):
    rows = [[name, str(counts['changes_of'].get(name, 0)), f'{100 * share:.1f}']
            for name, share in counts['mismatch'].items()
            if name not in (FIXED,) and not name.startswith(('least', 'recursive', 'the same'))]
    return Table(['method', 'cases with a false load change', 'MODEL_MISMATCH [% of the time]'],
                 rows)


def _cost_blocks(counts):
    cost = counts['microseconds_per_sample']
    if not counts.get('cost'):
        return [Heading('Cost'), Table(['method', 'microseconds per 20 ms sample'],
                                       [[name, f'{value:.0f}'] for name, value in cost.items()])]
    unit = counts['cost'][REGRESSOR]['mean']
    rows = [[name, *(f'{1e6 * c[key]:.0f}' for key in ('mean', 'p50', 'p99')),
             *(f'{c[key] / unit:.0f}' for key in ('mean', 'p99'))]
            for name, c in counts['cost'].items()]
    return [Heading('Cost'), Text('Processor time, measured beside other work.'), Table(
        ['per 20 ms sample', 'mean [us]', 'p50 [us]', 'p99 [us]',
         f'mean / {REGRESSOR}', 'p99 / the same'], rows)]


def _fallback(names):
    if not names:
        return ''
    return (f' No learned artefact for this arm: {", ".join(f"`{name}`" for name in names)} would '
            f'run as `{WITHOUT_NETWORK}` and is not shown twice.')


def suite_blocks(title, about, content, verdict_rows, command, commit):
    """Return the blocks of a suite's page; content: as of scores.json."""
    scores, counts = content['scores'], content['overview']
    out = [
        Heading(title, 1),
        Text(f'{counts["scored"]} of {counts["cases"]} cases from {counts["plants"]} plants that '
             'training never saw. Every plant has its own model, '
             f'identified from {content["identified"]} without load. '
             f'False load changes: {counts["false_load_changes"]} cases.'
             + (f' Cases: {about}.' if about else '')
             + (f' **{content["failed"]} plants could not be measured.**'
                if content.get('failed') else '')
             + _fallback(content.get('fell_back'))),
        Text(f'Command: `{command}`, commit {commit}.')]
    if verdict_rows:
        out.append(Table(['goal', 'wanted', 'measured', 'reached'], [
            [what, goal, value, 'yes' if good else '**no**']
            for what, goal, value, good in verdict_rows]))
    return [*out, mass_picture(scores), _mass_table(scores), _percent_table(scores),
            _com_table(scores), _inertia_table(scores[leading(scores)]),
            *_determined_blocks(content.get('inertia')), *_network_blocks(content.get('network')),
            *hidden_blocks(content.get('hidden'), leading(scores)),
            *oracle_blocks(content.get('oracle'), leading(scores)),
            *_offline_blocks(content.get('offline')), *_interval_blocks(scores),
            *([Heading('Trust'), _trust_table(counts)] if counts.get('mismatch') else []),
            *_cost_blocks(counts)]
