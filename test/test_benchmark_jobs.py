"""Jobs of the benchmark: stored and read again, told where they break, spread over a cluster."""

from contextlib import suppress
import math
from multiprocessing import get_context
import os
import signal
import subprocess
import sys

import pytest

from hand_load_estimator import cli
from hand_load_estimator.benchmark import execute
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.workers import worker_results


def test_jobs_are_stored_and_read_again(tmp_path):
    jobs = {f'n{k}': (k,) for k in (1, 4)}
    first = execute.measure_all(math.sqrt, jobs, tmp_path, workers=0)
    assert first == {'n1': 1.0, 'n4': 2.0}
    (tmp_path / 'n1.json').write_text('"kept"')
    assert execute.measure_all(math.sqrt, jobs, tmp_path, workers=0)['n1'] == 'kept'


def test_a_broken_job_is_told_and_left_out(tmp_path):
    told = []
    found = execute.measure_all(math.sqrt, {f'n{k}': (k,) for k in (4, -1)}, tmp_path, 1,
                                write=told.append)
    assert found == {'n4': 2.0}
    assert any('n-1 failed: ValueError' in line for line in told)
    assert [path.name for path in tmp_path.iterdir()] == ['n4.json']
    with pytest.raises(ValueError):
        execute.measure_all(math.sqrt, {'n-1': (-1,)}, tmp_path, workers=0)


def test_a_cluster_gives_its_results_to_this_process(tmp_path, monkeypatch):
    """joblib's loky stands for it: the workers write nothing, and all of them are used."""
    joblib = pytest.importorskip('joblib', reason='joblib is not installed: no cluster to test')
    asked, kept = [], execute._keep
    monkeypatch.setattr(execute, '_keep', lambda *given: asked.append(os.getpid()) or kept(*given))
    given, config = [], joblib.parallel_config
    monkeypatch.setattr(joblib, 'parallel_config', lambda **told: given.append(told) or config(
        **{**told, 'n_jobs': 2}))
    told, jobs = [], {f'n{k}': (k,) for k in (4, -1, 9)}
    found = execute.measure_all(math.sqrt, jobs, tmp_path, backend='loky', write=told.append)
    assert found == {'n4': 2.0, 'n9': 3.0} and asked == [os.getpid()] * 2
    assert given[-1] == {'backend': 'loky', 'n_jobs': -1}
    assert any('n-1 failed: ValueError' in line for line in told)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['n4.json', 'n9.json']
    # What is there is not measured again, and what failed is tried.
    (tmp_path / 'n9.json').write_text('"kept"')
    jobs['n-1'] = (16,)
    found = execute.measure_all(math.sqrt, jobs, tmp_path, 2, 'loky', told.append)
    assert found == {'n4': 2.0, 'n-1': 4.0, 'n9': 'kept'} and len(asked) == 3


def test_a_cluster_needs_joblib(tmp_path, monkeypatch):
    import sys
    monkeypatch.setitem(sys.modules, 'joblib', None)
    with pytest.raises(ConfigurationError, match='--backend.*joblib'):
        execute.measure_all(math.sqrt, {'n1': (1,)}, tmp_path, 1, 'dask', lambda text: None)


@pytest.mark.parametrize('backend', ['nope', 'multiprocessing', ''])
def test_a_backend_that_cannot_serve_is_refused_before_the_run(tmp_path, capsys, backend):
    """Whether there is none of that name, or one whose results come only all at once."""
    pytest.importorskip('joblib', reason='joblib is not installed')
    for suite in ('base', 'base,cold'):
        assert cli.main(['benchmark', '--suite', suite, '--backend', backend, '--out',
                         str(tmp_path / 'out')]) == 2
        said = capsys.readouterr().err
        assert '--backend' in said and backend in said and said.count('\n') == 1
    assert not (tmp_path / 'out').exists()


# A shell starts what runs behind it with interrupts ignored, tests among it.
INTERRUPTED = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from hand_load_estimator.benchmark.execute import measure_all
jobs = {'quick': (0,), **{f'slow_{k}': (60,) for k in range(4)}}
try:
    measure_all(time.sleep, jobs, sys.argv[1], 2, sys.argv[2],
                lambda text: print(text, flush=True))
except KeyboardInterrupt:
    print('pages', flush=True)
"""


@pytest.mark.parametrize(('backend', 'send'), [
    ('processes', os.kill), ('processes', os.killpg), ('loky', os.kill)])
def test_one_interrupt_ends_a_run_and_its_workers(tmp_path, backend, send):
    """Sent to the command alone, and to its workers too, as a terminal does."""
    if backend != 'processes':
        pytest.importorskip('joblib', reason='joblib is not installed: no cluster to test')
    with subprocess.Popen([sys.executable, '-c', INTERRUPTED, str(tmp_path), backend], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          start_new_session=True) as run:
        try:
            assert '0 of 5' in run.stdout.readline() and '1/5' in run.stdout.readline()
            send(run.pid, signal.SIGINT)
            # The pipe ends with the last of the processes that hold it.
            said, _ = run.communicate(timeout=10.0)
            assert run.returncode == 0 and 'Traceback' not in said
            assert said.splitlines()[-1] == 'pages'
            assert [path.name for path in tmp_path.iterdir()] == ['quick.json']
        finally:
            with suppress(ProcessLookupError):
                os.killpg(run.pid, signal.SIGKILL)


def test_a_killed_worker_is_told_in_a_line():
    """As the kernel does when memory runs out."""
    with pytest.raises(ConfigurationError, match='killed, probably for want of memory'):
        list(worker_results(signal.raise_signal, [(signal.SIGKILL,)] * 3, 1))


def test_workers_leave_an_interrupt_to_their_parent():
    """So that none tells of it, nor one that took the place of another."""
    ask = signal.SIG_BLOCK, ()
    held = list(worker_results(signal.pthread_sigmask, [ask] * 3, 1, get_context('spawn'), 1))
    assert [signal.SIGINT in mask for mask in held] == [True] * 3
    assert signal.SIGINT not in signal.pthread_sigmask(*ask)
