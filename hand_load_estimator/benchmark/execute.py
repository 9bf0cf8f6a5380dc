"""Measure jobs over all cores or a cluster; one JSON file per job, so that a kill costs little."""

from contextlib import closing
from functools import partial
import json
from multiprocessing import get_context
import os
from pathlib import Path
import time

from ..errors import ConfigurationError
from ..files.whole_file import whole_file
from ..workers import worker_results

PROCESSES = 'processes'


def stored(measure, label, arguments, folder):
    """
    Return the content of folder/<label>.json, measured and written unless it is there.

    measure(*arguments) -> JSON content. Another machine may work in the same folder.
    """
    path = _path(folder, label)
    if path.exists():
        return json.loads(path.read_text('utf-8'))
    return _keep(path, json.dumps(measure(*arguments)))


def _path(folder, label):
    return Path(folder) / f'{label}.json'


def _keep(path, text):
    """Write the text of a measured job; return its content."""
    with whole_file(path) as part:
        part.write_text(text, encoding='utf-8')
    # As the next run will read it: JSON makes lists of tuples.
    return json.loads(text)


def measure_all(measure, jobs, folder, workers=None, backend=PROCESSES, write=print,
                alone=False, failures=None):
    """
    Return {label: content} of jobs {label: arguments}, in their order.

    measure: a function of a module. workers: processes (None: one per core, or all that the
    backend has; 0: this process). backend: `processes`, or one of joblib's (loky, dask, ray, ...)
    where joblib is installed; its workers need the package and the files that arguments name,
    and results come back to this process. A job that raises in a worker is told and left out;
    the next run tries it again. alone: one job at a time, each in a process of its own, here and
    not on the cluster. failures: a dict that takes {label: why} of the jobs left out.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    if workers == 0:
        return {label: stored(measure, label, arguments, folder)
                for label, arguments in jobs.items()}
    results = {label: stored(measure, label, arguments, folder)
               for label, arguments in jobs.items() if _path(folder, label).exists()}
    write(f'{len(results)} of {len(jobs)} are there')
    calls = [(measure, label, arguments, folder) for label, arguments in jobs.items()
             if label not in results]
    run = partial(_processes, jobs_each=1) if alone else runner_of(backend)
    began, done, tried = time.monotonic(), len(results), 0
    with closing(run(calls, 1 if alone else workers)) as outcomes:
        for label, content, failure in outcomes:
            tried += 1
            if failure:
                write(f'{label} failed: {failure}')
                if failures is not None:
                    failures[label] = failure
                continue
            results[label] = content
            left = (time.monotonic() - began) / tried * (len(calls) - tried)
            write(f'{done + tried}/{len(jobs)}  {left / 60.0:.1f} min left  {label}')
    return {label: results[label] for label in jobs if label in results}


def _attempt(work, label, *arguments):
    """Return label, what work(*arguments) returns, and why there is nothing."""
    try:
        return label, work(*arguments), ''
    except Exception as error:
        # One broken plant must not lose the hours behind the others; the page counts it.
        return label, None, f'{type(error).__name__}: {error}'


def runner_of(backend):
    """
    Return run(calls, workers) -> iterator of outcomes, on a backend as of measure_all.

    Raises ConfigurationError where there is no such backend.
    """
    return _processes if backend == PROCESSES else _joblib_runner(backend)


def _processes(calls, workers, jobs_each=None):
    # One thread per process, told before a worker loads numpy: cores times threads is slower.
    os.environ.setdefault('OMP_NUM_THREADS', '1')
    return worker_results(_attempt, [(stored, call[1], *call) for call in calls], workers,
                          get_context('spawn'), jobs_each)


def _as_text(measure, arguments):
    return json.dumps(measure(*arguments))


def _joblib_runner(backend):
    try:
        from joblib import delayed, Parallel, parallel_config
        with parallel_config(backend=backend):
            Parallel(return_as='generator_unordered')
    except ModuleNotFoundError:
        raise ConfigurationError('--backend', 'needs joblib, which is not installed', backend,
                                 PROCESSES, '`pip install joblib`, or leave --backend out') \
            from None
    except ValueError as error:
        raise ConfigurationError('--backend', 'cannot be used', backend,
                                 f'{PROCESSES}, or one of joblib', str(error)) from None

    def run(calls, workers):
        """Yield the outcomes of calls as they come, from so many workers (None: all)."""
        paths = {label: _path(folder, label) for _, label, _, folder in calls}
        # -1 is joblib's word for all that a backend has.
        with parallel_config(backend=backend, n_jobs=workers or -1):
            for label, text, failure in Parallel(return_as='generator_unordered')(
                    delayed(_attempt)(_as_text, label, measure, arguments)
                    for measure, label, arguments, _ in calls):
                # Written here: workers of a cluster need not see this disk.
                yield label, None if failure else _keep(paths[label], text), failure
    return run
