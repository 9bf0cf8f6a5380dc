"""The goals of issue 4 beside what the suites measured: one table, nothing rounded to a yes."""

from ..load import MESSAGE_ORDER
from .contestants import DEFAULT, NOMINAL, REGRESSOR, TEXTBOOK, TEXTBOOK_CAREFUL
from .document import Table

NOT_MEASURED = 'not measured'
# The coverage goal counts from here on.
ENOUGH_CASES, ENOUGH_PLANTS = 2000, 40


def _row(what, wanted, measured=NOT_MEASURED, reached=None):
    return what, wanted, measured, reached


class _Accuracy:
    """The scores of the default method in one suite's content, by time."""

    def __init__(self, content):
        self.scores = content['scores']
        self.overview = content['overview']
        self.at = {entry['time']: entry for entry in self.scores[DEFAULT]}

    def mass(self, time, figure='rmse', name=DEFAULT):
        entries = {entry['time']: entry for entry in self.scores[name]}
        return entries[time]['mass'][figure]


def _usable(content):
    return _Accuracy(content) if content and DEFAULT in content.get('scores', {}) else None


def _limit(what, wanted, value, limit, unit, scale=1.0):
    return _row(what, wanted, f'{scale * value:.3g} {unit}'.strip(), bool(scale * value <= limit))


def _mass_rows(base):
    rows = [('mass, 0.2 s after motion start, 95th percentile', 5.0, '0.2 s'),
            ('mass, 0.5 s, 95th percentile', 1.5, '0.5 s')]
    out = []
    for what, limit, time in rows:
        wanted = f'<= {limit:g} % of rated'
        out.append(_row(what, wanted) if base is None else _limit(
            what, wanted, base.at[time]['mass_percent_of_rated']['p95'], limit, '%'))
    for time, grams in (('1 s', 60.0), ('3 s', 10.0), ('10 s', 5.0)):
        what, wanted = f'mass, {time}, RMSE', f'<= {grams:g} g'
        out.append(_row(what, wanted) if base is None else _limit(
            what, wanted, base.mass(time), grams, 'g', 1e3))
    what, wanted = 'mass, 10 s, ratio to the Cramer-Rao bound', '<= 2'
    out.append(_row(what, wanted) if base is None else _limit(
        what, wanted, base.mass('10 s') / base.at['10 s']['bound_mass_rmse'], 2.0, ''))
    what, wanted = 'centre of mass, 3 s, loads >= 2 kg, median', '<= 3 mm'
    out.append(_row(what, wanted) if base is None else _limit(
        what, wanted, base.at['3 s']['com']['median'], 3.0, 'mm', 1e3))
    return out


def _inertia_rows(content):
    rows = (('inertia suite: moments declared determined where the bound is below 5 %', '100 %'),
            ('inertia suite: median error of those', '<= 15 %'))
    found = (content or {}).get('inertia', {}).get(DEFAULT)
    if not found:
        return [_row(*row) for row in rows]
    declared = 100.0 * found['declared']
    return [_row(*rows[0], f'{declared:.0f} % of {found["due"]}', bool(declared >= 100.0)),
            _limit(*rows[1], found['median_error'], 15.0, '%')]


def _coverage_rows(base, undeclared):
    first = ('coverage of 95 % intervals, every parameter and time', '93 to 97 %')
    second = ('median width over the bound, every parameter and time', '<= 3')
    third = ('the same coverage with an undeclared effect', '>= 90 %')
    out = []
    if base is None:
        out += [_row(*first), _row(*second)]
    else:
        low, high = _range(base)
        counts = base.overview
        enough = counts['scored'] >= ENOUGH_CASES and counts['plants'] >= ENOUGH_PLANTS
        told = f'{low:.1f} to {high:.1f} % ({counts["scored"]} cases, {counts["plants"]} plants'
        out.append(_row(*first, told + (')' if enough else '; too few to count)'),
                        bool(enough and low >= 93.0 and high <= 97.0)))
        width = max(e['width_over_bound'][m] for e in base.at.values() for m in MESSAGE_ORDER)
        out.append(_limit(*second, width, 3.0, ''))
    if undeclared is None:
        return [*out, _row(*third)]
    low, high = _range(undeclared)
    return [*out, _row(*third, f'{low:.1f} to {high:.1f} %', bool(low >= 90.0))]


def _range(suite):
    shares = [100.0 * e['coverage'][m]['share'] for e in suite.at.values()
              for m in MESSAGE_ORDER]
    return min(shares), max(shares)


def _rival_rows(base):
    out = []
    for what, names, factor in (
            ('recursive least squares, nominal model, over ours at 1 s', (NOMINAL,), 10.0),
            ('best least squares with Coulomb + viscous over ours at 1 s',
             (TEXTBOOK, TEXTBOOK_CAREFUL), 4.0)):
        wanted = f'>= {factor:g} x'
        if base is None or not all(name in base.scores for name in names):
            out.append(_row(what, wanted))
            continue
        ratio = min(base.mass('1 s', name=name) for name in names) / base.mass('1 s')
        out.append(_row(what, wanted, f'{ratio:.1f} x', bool(ratio >= factor)))
    return out


def _network_row(content):
    what, wanted = "the network's own share of the error at 1 s, mass", '>= 20 %, or said'
    shares = {share['time']: share for share in (content or {}).get('network', ())}
    if not shares:
        return _row(what, wanted)
    gain = shares['1 s']['mass']
    said = f'{gain:.0f} %' + ('' if gain >= 20.0 else ': below 20 %')
    return _row(what, wanted, said, bool(gain >= 20.0))


def _cost_row(content):
    what, wanted = f'per sample over {REGRESSOR}', 'mean <= 30, p99 told'
    cost = (content or {}).get('cost') or (content or {}).get('overview', {}).get('cost')
    if not cost or DEFAULT not in cost:
        return _row(what, wanted)
    unit = cost[REGRESSOR]['mean']
    mean, tail = (cost[DEFAULT][key] / unit for key in ('mean', 'p99'))
    return _row(what, wanted, f'mean {mean:.0f}, p99 {tail:.0f}', bool(mean <= 30.0))


def _trust_rows(contents, base):
    clean = ('MODEL_MISMATCH on clean plants', '< 1 % of the time')
    out = []
    if base is None or 'mismatch' not in base.overview:
        out.append(_row(*clean))
    else:
        share = 100.0 * base.overview['mismatch'][DEFAULT]
        out.append(_row(*clean, f'{share:.2f} %', bool(share < 1.0)))
    seen = ('load change: 95th percentile of the delay after motion', '<= 0.2 s, none missed')
    false = ('false load changes while running from cold', '< 1 per 10 h')
    found = contents.get('changes', {}).get('methods', {}).get(DEFAULT)
    if not found:
        return [*out, _row(*seen), _row(*false)]
    out.append(_row(*seen, f'{found["delay_p95"]:.2f} s (median {found["delay_median"]:.2f}), '
                    f'{found["missed"]} of {found["changes"]} missed',
                    bool(found['delay_p95'] <= 0.2 and not found['missed'])))
    per_ten = 10.0 * found['false_alarms'] / found['hours'] if found['hours'] else float('nan')
    enough = found['hours'] >= 10.0
    told = f'{found["false_alarms"]} in {found["hours"]:.1f} h'
    return [*out, _row(*false, told + ('' if enough else '; too few to count'),
                       bool(enough and per_ten < 1.0))]


def _cold_row(cold, warm):
    what, wanted = 'cold over warm, mass RMSE, worst time', '<= 1.5 x'
    if cold is None or warm is None:
        return _row(what, wanted)
    ratios = {time: cold.mass(time) / warm.mass(time) for time in cold.at}
    worst = max(ratios, key=ratios.get)
    return _row(what, wanted, f'{ratios[worst]:.2f} x at {worst}, {ratios["1 s"]:.2f} x at 1 s',
                bool(ratios[worst] <= 1.5))


def _soak_row(content):
    what, wanted = 'soak: memory and time per message', '24 h, flat, faster than real time'
    if not content:
        return _row(what, wanted)
    good = (content['hours'] >= 24.0 and content['flat_memory'] and content['flat_time']
            and content['times_real_time'] > 1.0)
    return _row(what, wanted, f'{content["hours"]:.1f} h at {content["times_real_time"]:.0f} x, '
                f'RSS {content["growth_mib"]:+.1f} MiB, time per message '
                f'{content["time_drift_percent"]:+.0f} %', bool(good))


def goal_rows(contents):
    """
    Return (goal, wanted, measured, reached) of every goal; reached None where not measured.

    contents: {suite: content of its scores.json}, as far as there are any. The default method's
    figures count, except where it says otherwise.
    """
    suite = {name: _usable(contents.get(name)) for name in ('base', 'undeclared', 'cold', 'warm')}
    base = contents.get('base')
    return [*_mass_rows(suite['base']), *_inertia_rows(contents.get('inertia')),
            *_coverage_rows(suite['base'], suite['undeclared']),
            *_rival_rows(suite['base']), _network_row(base),
            _cost_row(contents.get('cost') or base), *_trust_rows(contents, suite['base']),
            _cold_row(suite['cold'], suite['warm']), _soak_row(contents.get('soak'))]


def goal_table(rows):
    """Return the Table of goal_rows."""
    said = {True: 'yes', False: '**no**', None: '-'}
    return Table(('goal (issue 4)', 'wanted', 'measured', 'reached'),
                 tuple((what, wanted, measured, said[reached])
                       for what, wanted, measured, reached in rows))
