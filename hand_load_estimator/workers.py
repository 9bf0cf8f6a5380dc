"""Worker processes that do not outlive what they work for."""

from concurrent.futures import as_completed, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import active_children, get_context
import os
import signal
import threading
import time

from .errors import ConfigurationError


def worker_results(work, calls, count=None, context=None, jobs_each=None):
    """
    Yield what work(*call) returns of each call, as they come, from processes.

    count: processes (None: one per core); context: of multiprocessing (None: fork, which starts
    at once; workers are children of this process, so no fork server); jobs_each: calls until a
    process is replaced (None: never), not with fork. Where this ends before the last result
    (Ctrl-C, an error of a call, `close`) the processes are ended at once. Raises
    ConfigurationError where one was killed.
    """
    others = active_children()
    with ProcessPoolExecutor(count or os.cpu_count() or 1, context or get_context('fork'),
                             _end_with, (os.getpid(),), max_tasks_per_child=jobs_each) as pool:
        try:
            for job in as_completed(_submitted(pool, work, calls)):
                yield job.result()
        except BaseException as error:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(active_children()).difference(others):
                process.kill()
            if isinstance(error, BrokenProcessPool):
                raise ConfigurationError(
                    'a worker process', 'was killed, probably for want of memory',
                    todo='free some and give the command again: it goes on with what is done'
                ) from None
            raise


def _submitted(pool, work, calls):
    # Workers keep the mask that they start with: a terminal sends Ctrl-C to them too, and they
    # would tell of it one by one. The pool's thread, which replaces them, starts here as well.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return [pool.submit(work, *call) for call in calls]
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with(parent):
    """End this process soon after `parent` (a pid), also when that was killed outright."""
    def watch():
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)
    threading.Thread(target=watch, daemon=True).start()
