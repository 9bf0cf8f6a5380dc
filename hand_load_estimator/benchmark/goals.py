"""The goals of issue 4 beside what the suites measured: one table, nothing rounded to a yes."""

from dataclasses import replace
from itertools import product

from .document import Table
from .goal_judges import judged_rows, JUDGED


def goal_rows(runs):
    """
    Return the GoalRows of all goals.

    runs: (name, content of scores.json) of any runs of any suites. The default method's figures
    count, except where a row says otherwise; of several runs of a suite, those of the one with
    most cases (or hours) that measured the goal.
    """
    out = []
    for suites, judge, enough in JUDGED:
        runs = sorted(runs, key=lambda run: -(_cases(run[1])[0] if enough else _hours(run[1])))
        rows = judged_rows(judge, [None] * len(suites))
        for chosen in product(*([r for r in runs if r[1]['suite'] == s] for s in suites)):
            names = tuple(name for name, _ in chosen)
            judged = judged_rows(judge, [content for _, content in chosen])
            if enough:
                judged = [_counted(row, [_cases(c) for _, c in chosen], enough) for row in judged]
            rows = [replace(new, runs=names) if old.reached is None and new.reached is not None
                    else old for old, new in zip(rows, judged)]
        out += rows
    return out


def _counted(row, measured, enough):
    """Return a GoalRow, not reached where a run's cases or plants are fewer than enough."""
    if row.reached is None or all(has >= need for found in measured
                                  for has, need in zip(found, enough)):
        return row
    return replace(row, reached=False, measured=f'{row.measured}; fewer than {enough[0]} cases '
                   f'from {enough[1]} plants: too few to count')


def _cases(content):
    """Return how many cases a run scored, and of how many plants."""
    counts = content.get('overview', {'scored': 0, 'plants': 0})
    return counts['scored'], counts['plants']


def _hours(content):
    """Return the hours of running of a run."""
    hours = [found['hours'] for found in content.get('methods', {}).values() if 'hours' in found]
    return max(hours, default=content.get('hours', 0.0))


def goal_table(rows, with_runs=True):
    """Return the Table of GoalRows; with_runs: for the page above the folders of the runs."""
    said = {True: 'yes', False: '**no**', None: '-'}
    head = ('goal (issue 4)', 'wanted', 'measured', 'reached')
    body = [(row.goal, row.wanted, row.measured, said[row.reached]) for row in rows]
    if not with_runs:
        return Table(head, tuple(body))
    links = [', '.join(f'[{name}]({name}/README.md)' for name in row.runs) or '-' for row in rows]
    return Table((*head, 'run'), tuple((*row, link) for row, link in zip(body, links)))
