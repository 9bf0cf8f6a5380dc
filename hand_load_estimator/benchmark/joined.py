"""The runs below one folder joined to one table of goals, each with its command and commit."""

from dataclasses import asdict
import json
import math
from pathlib import Path

from ..errors import ConfigurationError
from ..files.whole_file import whole_file
from .document import Heading, Table, Text, write_pages
from .goals import goal_rows, goal_table

# Runs of another of these are no part of the same table.
SAME = ('robot', 'artefact', 'development')


def run_name(suite, cases=None, hours=None, names=()):
    """Return the folder of a run: its suite and what was chosen, or the suite alone."""
    chosen = (cases and str(cases), hours and f'{hours:g}h', '+'.join(names))
    return '-'.join([suite, *filter(None, chosen)])


def write_scores(folder, content):
    """Write scores.json as strict JSON: a figure that there is none of is null."""
    with whole_file(Path(folder) / 'scores.json') as part:
        part.write_text(json.dumps(_plain(content), indent=1, allow_nan=False) + '\n',
                        encoding='utf-8')


def _plain(content):
    if isinstance(content, dict):
        return {key: _plain(value) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [_plain(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content


def runs_under(folder):
    """Return {folder name: content of scores.json} of the runs measured below a folder."""
    found = {path.parent.name: json.loads(path.read_text('utf-8'))
             for path in sorted(Path(folder).glob('*/scores.json'))}
    # Other pages (the effects suite's) tell no run.
    return {name: content for name, content in found.items() if 'run' in content}


def refuse_mixture(folder, own):
    """Raise ConfigurationError where a folder holds runs of another robot, artefact or seeds."""
    for name, content in runs_under(folder).items():
        if any(content['run'][key] != own[key] for key in SAME):
            raise ConfigurationError(Path(folder) / name, 'is of another robot, artefact or '
                                     'seeds, and one table holds one of each',
                                     todo='remove it or give another --out')


def write_index(folder, schema, failed=None):
    """
    Write scores.json and the page of the goals over all runs below a folder; return Markdown.

    failed: {suite: why} of what could not be measured this time.
    """
    runs, failed = runs_under(folder), failed or {}
    rows = goal_rows(list(runs.items()))
    told = [{'folder': name, 'suite': content['suite'], **content['run']}
            for name, content in runs.items()]
    write_scores(folder, {
        'schema': schema, 'runs': told, 'failed': failed,
        'goals': [asdict(row) for row in rows]})
    return write_pages(folder, [
        Heading('Benchmark', 1),
        Text('Every goal is judged on the run with most cases that measured it, named in its '
             'row.' + _caveats(told)), goal_table(rows), Heading('Runs'),
        Table(('run', 'cases', 'commit', 'command'), tuple(
            (f'[{run["folder"]}]({run["folder"]}/README.md)', _cases(runs[run['folder']]),
             run['commit'], f'`{run["command"]}`') for run in told)),
        *(Text(f'**Not measured: {name}.** {why}') for name, why in failed.items())])


def _cases(content):
    if 'overview' not in content:
        return '-'
    counts = content['overview']
    return f'{counts["scored"]} of {counts["cases"]}, {counts["plants"]} plants'


def _caveats(runs):
    commits = {run['commit'] for run in runs}
    return (f' **Runs are of {len(commits)} commits.**' if len(commits) > 1 else '') + (
        ' **On seeds for looking and choosing, not the benchmark\'s.**'
        if any(run['development'] for run in runs) else '')
