"""A ROS domain that nobody else on this machine holds, for what must never meet a real arm."""

import fcntl
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path

from ..errors import ConfigurationError

# Domains above 101 may meet the ports Linux hands out; 0 is everybody's default.
_DOMAINS = range(1, 102)
# What leads to other machines or to a shell's own domain.
_SET = ('ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_STATIC_PEERS')


@contextmanager
def free_domain():
    """
    Yield a domain id held by a lock file, and not the shell's own.

    Raises ConfigurationError when all are in use.
    """
    number, lock = _locked(os.environ.get('ROS_DOMAIN_ID'))
    with lock:
        yield number


@contextmanager
def own_domain():
    """Run in a free_domain() and on this machine only, whatever the shell says."""
    with free_domain() as number:
        before = {name: os.environ.pop(name, None) for name in _SET}
        os.environ.update(ROS_DOMAIN_ID=str(number), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
        try:
            yield number
        finally:
            for name, value in before.items():
                os.environ.pop(name, None)
                if value is not None:
                    os.environ[name] = value


def _locked(taken):
    """Return a domain id other than the text `taken`, and the open file that locks it."""
    folder = Path(tempfile.gettempdir())
    for k in range(len(_DOMAINS)):
        number = _DOMAINS[(os.getpid() + k) % len(_DOMAINS)]
        if str(number) == taken:
            continue
        try:
            lock = open(folder / f'hand_load_domain_{number}.lock', 'a', encoding='utf-8')
        except OSError:
            continue  # another user's
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return number, lock
        except OSError:
            lock.close()
    raise ConfigurationError('ROS domain', 'none is free on this machine', allowed='1 to 101',
                             todo='end a demo or test, or remove '
                                  f'{folder}/hand_load_domain_*.lock')
