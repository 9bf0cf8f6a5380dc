"""Run the effects suite over all cores, resume what was done, write the page."""

from concurrent.futures import as_completed, ProcessPoolExecutor
import json
from multiprocessing import get_context
import os
from pathlib import Path
import time

from ..robot import load_robot
from ..shared_files import find_shared
from ..workers import end_with
from .effect_cases import suite_cases
from .effect_measure import measure_case
from .effect_page import effects_markdown
from .effect_scores import effect_rows, pair_rows, totals
from .run import commit_now, same_run

SUITE = 'effects'


def run_cases(cases, robot_path, folder, workers=None, write=print):
    """
    Measure EffectCases into folder/<label>.json and return their results in the cases' order.

    workers: processes (None: one per core; 0: in this process, for debugging). What is there
    already is read. A case that raises becomes a result with `failed` and is tried again by
    the next run.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    jobs = [(case, str(robot_path), str(folder)) for case in cases]
    if workers == 0:
        return [json.loads(measure_case(*job).read_text('utf-8')) for job in jobs]
    missing = sum(not (folder / f'{case.label}.json').exists() for case in cases)
    write(f'{len(jobs) - missing} of {len(jobs)} cases are there')
    began, done, results = time.monotonic(), 0, {}
    # One thread per process, told before a worker loads numpy: cores times threads is slower.
    os.environ.setdefault('OMP_NUM_THREADS', '1')
    with ProcessPoolExecutor(workers or os.cpu_count() or 1, get_context('spawn'),
                             end_with, (os.getpid(),)) as pool:
        running = {pool.submit(_measure, *job): job[0] for job in jobs}
        for job in as_completed(running):
            result, fresh = job.result()
            results[running[job].label] = result
            done += fresh
            if fresh:
                left = (time.monotonic() - began) / done * (missing - done)
                write(f'case {done}/{missing}  {left / 60.0:.1f} min left  '
                      f'{running[job].label}')
    return [results[case.label] for case in cases]


def _measure(case, robot_path, folder):
    """Return the result of a case, and whether it was not there before."""
    fresh = not (Path(folder) / f'{case.label}.json').exists()
    try:
        return json.loads(measure_case(case, robot_path, folder).read_text('utf-8')), fresh
    except Exception as error:
        # One broken case of 150 must not lose the hours behind the others; the page names it.
        return {'label': case.label, 'kind': case.kind, 'plant': case.plant,
                'effects': [{'name': h.name, 'strength': h.strength, 'joints': []}
                            for h in case.hidden],
                'failed': f'{type(error).__name__}: {error}'}, fresh


def run_effects(robot_name, folder, command, write=print):
    """Measure the suite into `folder`: raw results per case, scores.json, README.md."""
    robot_path = find_shared(robot_name, 'robots')
    out = Path(folder)
    raw = out / 'raw'
    raw.mkdir(parents=True, exist_ok=True)
    key = {'suite': SUITE, 'robot': Path(robot_path).read_text('utf-8'), 'commit': commit_now()}
    same_run(raw, key)
    results = run_cases(suite_cases(load_robot(robot_path)), robot_path, raw, write=write)
    (out / 'scores.json').write_text(json.dumps(
        {'schema': 'hand_load/benchmark/1', 'suite': SUITE, 'totals': totals(results),
         'effects': effect_rows(results), 'pairs': pair_rows(results)}, indent=1) + '\n',
        encoding='utf-8')
    page = effects_markdown(results, command, key['commit'])
    (out / 'README.md').write_text(page, encoding='utf-8')
    return page
