"""What each goal of issue 4 wants, and what the content of a suite's scores.json says of it."""

from dataclasses import dataclass, replace
from math import isfinite

from ..load import MESSAGE_ORDER
from ..motion import BLOCK
from .changes import CHANGES, PLANTS
from .contestants import (DEFAULT, NOMINAL, OUR_MODEL, REGRESSOR, TEXTBOOK, TEXTBOOK_CAREFUL,
                          WITHOUT_NETWORK)
from .cost import RATES, seconds_per_joint_state
from .offline import RIVALS
from .suites import SUITES

NOT_MEASURED = 'not measured'
# Of these suites a judge gets the default method's accuracy in place of the content.
_ON_ACCURACY = ('base', 'undeclared', 'cold', 'warm')
# The rivals on measured runs; least squares on our torque model is none.
_ON_RUNS = (TEXTBOOK, TEXTBOOK_CAREFUL, NOMINAL, *RIVALS)


@dataclass(frozen=True)
class GoalRow:
    """One goal: what is wanted and measured; reached is None where not; names of its runs."""

    goal: str
    wanted: str
    measured: str = NOT_MEASURED
    reached: bool | None = None
    runs: tuple = ()


class _Accuracy:
    """The scores of the default method in one suite's content, by time."""

    def __init__(self, content):
        self.scores = content['scores']
        self.overview = content['overview']
        self.network = content.get('network', ())
        self.at = {entry['time']: entry for entry in self.scores[DEFAULT]}

    @property
    def counted(self):
        """Cases and plants there are."""
        return self.overview['cases'], self.overview['plants']

    def mass(self, time, figure='rmse', name=DEFAULT):
        """Return a figure of a method's mass error at a time."""
        entries = {entry['time']: entry for entry in self.scores[name]}
        return entries[time]['mass'][figure]


def _usable(content):
    return _Accuracy(content) if content and DEFAULT in content.get('scores', {}) else None


def _limit(what, wanted, value, limit, unit, scale=1.0):
    # Few cases may hold nothing to judge: no load heavy enough.
    if value is None or not isfinite(value):
        return GoalRow(what, wanted)
    value = scale * value
    return GoalRow(what, wanted, f'{value:.3g} {unit}'.strip(), bool(value <= limit))


def _mass_rows(base):
    rows = [('mass, 0.2 s after motion start, 95th percentile', 5.0, '0.2 s'),
            ('mass, 0.5 s, 95th percentile', 1.5, '0.5 s')]
    out = []
    for what, limit, time in rows:
        wanted = f'<= {limit:g} % of rated'
        out.append(GoalRow(what, wanted) if base is None else _limit(
            what, wanted, base.at[time]['mass_percent_of_rated']['p95'], limit, '%'))
    for time, grams in (('1 s', 60.0), ('3 s', 10.0), ('10 s', 5.0)):
        what, wanted = f'mass, {time}, RMSE', f'<= {grams:g} g'
        out.append(GoalRow(what, wanted) if base is None else _limit(
            what, wanted, base.mass(time), grams, 'g', 1e3))
    what, wanted = 'mass, 10 s, ratio to the Cramer-Rao bound', '<= 2'
    out.append(GoalRow(what, wanted) if base is None else _limit(
        what, wanted, base.mass('10 s') / base.at['10 s']['bound_mass_rmse'], 2.0, ''))
    what, wanted = 'centre of mass, 3 s, loads >= 2 kg, median', '<= 3 mm'
    out.append(GoalRow(what, wanted) if base is None else _limit(
        what, wanted, base.at['3 s']['com']['median'], 3.0, 'mm', 1e3))
    return out


def _inertia_rows(content):
    rows = (('inertia suite: moments declared determined where the bound is below 5 %', '100 %'),
            ('inertia suite: median error of those', '<= 15 %'))
    found = (content or {}).get('inertia', {}).get(DEFAULT)
    if not found:
        return [GoalRow(*row) for row in rows]
    declared, error = 100.0 * found['declared'], found['median_error']
    of_those = (GoalRow(*rows[1], 'none declared', False) if not declared
                else _limit(*rows[1], error, 15.0, '%'))
    return [GoalRow(*rows[0], f'{declared:.0f} % of {found["due"]}', bool(declared >= 100.0)),
            of_those]


def _coverage_rows(base):
    first = ('coverage of 95 % intervals, every parameter and time', '93 to 97 %')
    second = ('median width over the bound, every parameter and time', '<= 3')
    if base is None:
        return [GoalRow(*first), GoalRow(*second)]
    low, high = _range(base)
    counts = base.overview
    told = f'{low:.1f} to {high:.1f} % ({counts["scored"]} cases, {counts["plants"]} plants)'
    width = _limit(*second, _widest(base.at.values()), 3.0, '')
    return [GoalRow(*first, told, bool(low >= 93.0 and high <= 97.0)),
            replace(width, measured=width.measured + _with_start_unknown(base))]


def _widest(entries):
    return max(e['width_over_bound'][m] for e in entries for m in MESSAGE_ORDER)


def _with_start_unknown(base):
    """Return in words the width over the bound that does not know friction's start."""
    entries = [e.get('start_unknown') for e in base.at.values()]
    # Runs of older code that are joined to the table have no such bound.
    return (f"; {_widest(entries):.3g} where the bound does not know friction's start"
            if all(entries) else '')


def _undeclared_rows(undeclared):
    goal = ('the same coverage with an undeclared effect', '>= 90 %')
    if undeclared is None:
        return [GoalRow(*goal)]
    cells = _cells(undeclared)
    low, high = (choose(cells, key=cells.get) for choose in (min, max))
    told = ' to '.join(f'{cells[cell]:.1f} % ({", ".join(cell)})' for cell in (low, high))
    over_all = sum(cells.values()) / len(cells)
    return [GoalRow(*goal, f'{told}, {over_all:.1f} % over all', bool(cells[low] >= 90.0))]


def _range(suite):
    shares = _cells(suite).values()
    return min(shares), max(shares)


def _cells(suite):
    """Return {(parameter, time): coverage [%]} of a suite."""
    return {(m, time): 100.0 * e['coverage'][m]['share'] for time, e in suite.at.items()
            for m in MESSAGE_ORDER}


def _rival_rows(base):
    out = []
    for what, names, factor in (
            ('recursive least squares, nominal model, over ours at 1 s', (NOMINAL,), 10.0),
            ('best least squares with Coulomb + viscous over ours at 1 s',
             (TEXTBOOK, TEXTBOOK_CAREFUL), 4.0)):
        wanted = f'>= {factor:g} x'
        if base is None or not all(name in base.scores for name in names):
            out.append(GoalRow(what, wanted))
            continue
        rival, ours = min(base.mass('1 s', name=name) for name in names), base.mass('1 s')
        ratio = rival / ours
        out.append(GoalRow(what, wanted, f'{ratio:.1f} x{_merit(base, rival, ours)}',
                           bool(ratio >= factor)))
    return out


def _merit(base, rival, ours):
    """Return in words which part of a rival's ratio the torque model has and which the method."""
    if OUR_MODEL not in base.scores:
        return ''
    between = base.mass('1 s', name=OUR_MODEL)
    return (f': torque model {rival / between:.1f} x, method {between / ours:.1f} x (least '
            'squares on our model over ours)')


def _network_rows(base):
    what, wanted = "the network's own share of the error at 1 s, mass", '>= 20 %, or said'
    shares = {share['time']: share for share in base.network} if base else {}
    if not shares:
        return [GoalRow(what, wanted)]
    gain = shares['1 s']['mass']
    said = f'{gain:.0f} %' + ('' if gain >= 20.0 else ': below 20 %')
    return [GoalRow(what, wanted, said, bool(gain >= 20.0))]


def _cost_rows(content):
    goal = (f'per sample of {1e3 * BLOCK:g} ms over {REGRESSOR}, undisturbed',
            'mean <= 30 (about 100 us), p99 told')
    # Runs of older code have the call between the method's samples only.
    if DEFAULT not in (content or {}).get('regressor_alone', {}):
        return [GoalRow(*goal)]
    cost, alone, beside = (content[what][DEFAULT]
                           for what in ('cost', 'regressor_alone', 'regressor'))
    mean, tail = (cost[key] / alone['mean'] for key in ('mean', 'p99'))
    told = (f'mean {mean:.0f}, p99 {tail:.0f} ({1e6 * cost["mean"]:.0f} and '
            f'{1e6 * cost["p99"]:.0f} us over {1e6 * alone["mean"]:.1f} us); mean '
            f'{cost["mean"] / beside["mean"]:.0f} over the call between the method\'s samples '
            f'({1e6 * beside["mean"]:.1f} us); '
            + _joint_state_told(content, alone['mean']))
    return [GoalRow(*goal, told, bool(mean <= 30.0))]


def _joint_state_told(content, unit):
    """Return in words what a joint state costs, of which not every one makes a sample."""
    each = {rate: seconds_per_joint_state(content, DEFAULT, rate) for rate in RATES}
    return 'a joint state with its share of a sample ' + ', '.join(
        f'{1e6 * seconds:.0f} us ({seconds / unit:.0f}) at {rate:g} Hz'
        for rate, seconds in each.items())


def _measured_arm_rows(content):
    """
    Judge ours by the default or, where no arm has its network, by what it falls back on.

    Rivals that name possible bodies only are never below zero, where most of the truth is: the
    second row gives everyone that.
    """
    goal = 'measured arms: better than every rival at the end of a run (median % of rated)'
    figures = {goal: 'median_percent',
               'the same where a mass below zero counts as zero (our own row)': 'possible_percent'}
    found = (content or {}).get('methods', {})
    ours = next((name for name in (DEFAULT, WITHOUT_NETWORK) if name in found), None)
    if ours is None or not all(name in found for name in _ON_RUNS):
        return [GoalRow(what, 'less than each') for what in figures]
    return [_against_rivals(what, key, found, ours) for what, key in figures.items()]


def _against_rivals(what, key, found, ours):
    error = {name: found[name][key] for name in (ours, *_ON_RUNS)}
    told = '; '.join(f'{name} {value:.2f}' for name, value in error.items())
    return GoalRow(what, 'less than each', told,
                   bool(error[ours] < min(error[name] for name in _ON_RUNS)))


def _mismatch_rows(base):
    goal = ('MODEL_MISMATCH on clean plants', '< 1 % of the time')
    if base is None or 'mismatch' not in base.overview:
        return [GoalRow(*goal)]
    share = 100.0 * base.overview['mismatch'][DEFAULT]
    return [GoalRow(*goal, f'{share:.2f} %', bool(share < 1.0))]


def _change_rows(content):
    seen = ('load change: 95th percentile of the delay after motion',
            '<= 0.2 s, none missed, early or counted again')
    found = (content or {}).get('methods', {}).get(DEFAULT)
    return [GoalRow(*seen, *_delay(found)) if found else GoalRow(*seen)]


def _alarm_rows(content):
    false = ('false load changes while running from cold', '< 1 per 10 h')
    found = (content or {}).get('methods', {}).get(DEFAULT)
    if not found:
        return [GoalRow(*false)]
    hours, count = found['hours'], found['false_alarms']
    told = f'{count} in {hours:.1f} h' + ('' if hours >= 10.0 else '; too few to count')
    return [GoalRow(*false, told, bool(hours >= 10.0 and 10.0 * count / hours < 1.0))]


def _delay(found):
    """Return what is told of the delay of load changes, and whether the goal is reached."""
    told = (f'{found["missed"]} of {found["changes"]} missed ({found["wrong"]} seen with another '
            f'load at the end), {found["too_early"]} early, {found["extra"]} counted again')
    if not found['changes'] > found['missed']:
        return told, False
    # A change that is counted again is a false one.
    good = found['delay_p95'] <= 0.2 and not any(
        found[key] for key in ('missed', 'too_early', 'extra'))
    return f'{found["delay_p95"]:.2f} s (median {found["delay_median"]:.2f}), {told}', bool(good)


def _cold_rows(cold, warm):
    what, wanted = 'cold over warm, mass RMSE, worst time', '<= 1.5 x'
    # They are the same cases but for the temperature only where both are as many.
    if cold is None or warm is None or cold.counted != warm.counted:
        return [GoalRow(what, wanted)]
    ratios = {time: cold.mass(time) / warm.mass(time) for time in cold.at}
    worst = max(ratios, key=ratios.get)
    return [GoalRow(what, wanted, f'{ratios[worst]:.2f} x at {worst}, {ratios["1 s"]:.2f} x at '
                    '1 s', bool(ratios[worst] <= 1.5))]


def _soak_rows(content):
    what = 'soak: memory and time per message'
    wanted = '24 h, flat, no load change, faster than real time'
    if not content or content['method'] != DEFAULT:
        return [GoalRow(what, wanted)]
    good = (content['hours'] >= 24.0 and content['flat_memory'] and content['flat_time']
            and content['load_changes'] == 0 and content['times_real_time'] > 1.0)
    told = (f'{content["hours"]:.1f} h at {content["times_real_time"]:.0f} x, RSS '
            f'{content["growth_mib"]:+.1f} MiB, time per message '
            f'{content["time_drift_percent"]:+.0f} %, its 99th percentile '
            f'{content["tail_drift_percent"]:+.0f} %, {content["load_changes"]} load changes')
    return [GoalRow(what, wanted, told, bool(good))]


def _own(name):
    """Return cases and plants of a suite that nobody cut short."""
    return SUITES[name].count, SUITES[name].plants


# What is judged on which suites' runs, in the order of the table, and how many cases and plants
# a goal takes to be reached; None where cases are not what is counted.
JUDGED = (
    (('base',), _mass_rows, _own('base')), (('inertia',), _inertia_rows, _own('inertia')),
    (('base',), _coverage_rows, (2000, 40)),
    (('undeclared',), _undeclared_rows, _own('undeclared')),
    (('base',), _rival_rows, _own('base')), (('real',), _measured_arm_rows, None),
    (('base',), _network_rows, _own('base')), (('cost',), _cost_rows, None),
    (('base',), _mismatch_rows, _own('base')),
    (('changes',), _change_rows, (CHANGES, PLANTS)), (('changes',), _alarm_rows, None),
    (('cold', 'warm'), _cold_rows, _own('cold')), (('soak',), _soak_rows, None))


def judged_rows(judge, contents):
    """
    Return the GoalRows of one judge of JUDGED.

    contents: of scores.json, one of each suite that it judges, or None where that has no run.
    """
    return judge(*(_usable(content) if content and content['suite'] in _ON_ACCURACY else content
                   for content in contents))
