"""Run the effects suite over all cores, resume what was done, write the page."""

import json
from pathlib import Path

from ..files.shared_files import find_shared
from ..robot import load_robot
from .document import blocks_of, write_pages
from .effect_cases import suite_cases
from .effect_measure import case_result
from .effect_page import effects_markdown
from .effect_scores import effect_rows, pair_rows, totals
from .execute import measure_all, PROCESSES, runner_of
from .provenance import commit_now, same_run, sources
from .run import SCHEMA

SUITE = 'effects'


def run_cases(cases, robot_path, folder, workers=None, backend=PROCESSES, write=print):
    """
    Measure EffectCases into folder/<label>.json and return their results in the cases' order.

    folder, workers, backend: as of measure_all. What is there already is read. A case that raises
    in a worker becomes a result with `failed`, so that the page names it, and is tried again by
    the next run.
    """
    failures = {}
    found = measure_all(case_result, {case.label: (case, str(robot_path)) for case in cases},
                        folder, workers, backend, write, failures=failures)
    return [found[case.label] if case.label in found else _failed(case, failures[case.label])
            for case in cases]


def _failed(case, why):
    return {'label': case.label, 'kind': case.kind, 'plant': case.plant,
            'effects': [{'name': h.name, 'strength': h.strength, 'joints': []}
                        for h in case.hidden], 'failed': why}


def run_effects(robot_name, folder, command, write=print, workers=None, development=False,
                backend=PROCESSES):
    """
    Measure the suite into `folder`: raw results per case, scores.json, README.md, index.html.

    development: the cases of the seeds for looking and choosing; workers, backend: as of
    measure_all. Returns the page. A run broken off from the keyboard writes the pages of what it
    has.
    """
    runner_of(backend)
    robot_path = find_shared(robot_name, 'robots')
    out = Path(folder)
    raw = out / 'raw'
    raw.mkdir(parents=True, exist_ok=True)
    key = {'suite': SUITE, 'robot': Path(robot_path).read_text('utf-8'), 'commit': commit_now(),
           'sources': sources(), 'development': development}
    same_run(raw, key)
    cases = suite_cases(load_robot(robot_path), development)
    try:
        results = run_cases(cases, robot_path, raw, workers, backend, write)
    except KeyboardInterrupt:
        write_results(out, there(cases, raw), cases, command, key['commit'])
        raise
    return write_results(out, results, cases, command, key['commit'])


def there(cases, raw):
    """Return the results that a run broken off has left in `raw`, in the cases' order."""
    files = [Path(raw) / f'{case.label}.json' for case in cases]
    return [json.loads(file.read_text('utf-8')) for file in files if file.exists()]


def write_results(out, results, cases, command, commit):
    """Write scores.json and the pages of results of all or some of the cases; return the page."""
    (out / 'scores.json').write_text(json.dumps(
        {'schema': SCHEMA, 'suite': SUITE, 'totals': totals(results),
         'effects': effect_rows(results), 'pairs': pair_rows(results)}, indent=1) + '\n',
        encoding='utf-8')
    return write_pages(out, blocks_of(effects_markdown(results, command, commit, cases)))
