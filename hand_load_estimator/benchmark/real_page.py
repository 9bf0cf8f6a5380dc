"""The page of the real suite: overall figures of every method, then one table per figure."""

from .document import Heading, Table, Text
from .other_pages import left_out_told
from .real import MOMENTS
from .real_course import JUDGED_FROM
from .real_sets import SETS

_LATER = f'later than {JUDGED_FROM:g} s'


def real_blocks(content):
    """Return the blocks of the real suite."""
    methods, runs = content['methods'], content['runs']
    return [
        Heading('Measured recordings', 1),
        Text('Every set has its own model, identified from its training runs with the load those '
             'state (none for most); the error is the estimate in a test run less that mass. It '
             'should be zero. Without load, ours are judged before what they publish is '
             'kept above zero; `mujoco.sysid` and `figaroh` name no other masses, so one column '
             'takes every mass below zero for zero. The load of run load_2600 is known by the '
             'file name only. '
             f'Loads assumed: {_assumed(content)}.'
             + left_out_told(content, 'all training runs of a set carry one load')),
        Text('Times count from motion start. The load is the same all along each run: every load '
             'change counted is a false one. Rivals that look at a whole recording are asked at '
             '3 s, 10 s and the end only.'),
        Table(['mass error [% of rated]', 'runs', *(f'median, {m}' for m in MOMENTS),
               'median, end, none below zero', 'largest, end', f'largest, {_LATER}'],
              [[name, str(f['runs']), *(_told(f['percent_at'][m], '.2f') for m in MOMENTS),
                _told(f['possible_percent'], '.2f'), _told(f['worst_percent'], '.2f'),
                _told(f['later_percent'], '.1f')]
               for name, f in methods.items()]),
        Table(['method', '95 % interval holds at the end [% of runs]',
               f'the same {_LATER} [% of the time]', 'load changes counted',
               'MODEL_MISMATCH [% of the time]'],
              [[name, _percent(f['inside'], 0), _percent(f['time_inside']),
                _told(f['changes'], 'd'), _percent(f['mismatch'])]
               for name, f in methods.items()]),
        _table(f'mass error, {MOMENTS[-1]} [kg] (std)', content, _at_the_end),
        _table(f'mass error, {" / ".join(MOMENTS[:-1])} [kg]', content, _on_the_way),
        *(_course_table(what, runs, key, told) for what, key, told in (
            (f'largest mass error {_LATER} [kg]', 'worst', lambda found: _told(found, '.3f')),
            (f'95 % interval holds, {_LATER} [% of the time]', 'inside', _percent),
            ('load changes counted', 'changes', lambda found: _told(found, 'd')),
            ('MODEL_MISMATCH [% of the time]', 'mismatch', _percent)))]


def _assumed(content):
    """Return which loads of the real suite nobody has stated, and what they are taken for."""
    names = dict.fromkeys(run['set'] for run in content['runs'])
    return '; '.join(f'{name} {SETS[name].assumed}' for name in names
                     if name in SETS and SETS[name].assumed) or 'none'


def _told(value, form):
    return '-' if value is None else f'{value:{form}}'


def _percent(share, digits=1):
    return '-' if share is None else f'{100.0 * share:.{digits}f}'


def _of_run(run):
    return [f'{run["set"]}: {run["run"]}', f'{run["truth"]:g}']


def _table(what, content, cell):
    """Return a Table of runs by methods; cell(what a method said at MOMENTS, truth)."""
    names, nothing = list(content['methods']), [None] * len(MOMENTS)
    return Table([what, 'true [kg]', *names],
                 [[*_of_run(run), *(cell(run['methods'].get(name, nothing), run['truth'])
                                    for name in names)] for run in content['runs']])


def _at_the_end(found, truth):
    return '-' if found[-1] is None else f'{found[-1][0] - truth:+.3f} ({found[-1][1]:.3f})'


def _on_the_way(found, truth):
    return ' / '.join('-' if one is None else f'{one[0] - truth:+.2f}' for one in found[:-1])


def _course_table(what, runs, key, told):
    """Return a Table of one figure of the Courses, of the methods that have it."""
    names = dict.fromkeys(name for run in runs for name, course in run['course'].items()
                          if course[key] is not None)
    return Table([what, 'true [kg]', *names],
                 [[*_of_run(run), *(told(run['course'].get(name, {}).get(key)) for name in names)]
                  for run in runs])
