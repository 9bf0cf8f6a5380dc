"""
Entry points of the nodes.

The imports of a node take seconds on a small machine. A Ctrl-C that comes meanwhile must end it
in order too, so signals are heeded before anything else is imported.
"""

import sys
from importlib import import_module

from .signals import heed_signals


def _run(name, args):
    stop = heed_signals()
    try:
        main = import_module(f'.{name}_node', __package__).main
    except ModuleNotFoundError as error:
        print(f'error: {name}_node needs {error.name}, which is not installed; source a ROS 2 '
              'Jazzy or pip install -r requirements.txt', file=sys.stderr)
        return 2
    return 0 if stop else main(args)


def simulator(args=None):
    """Run simulator_node; return the exit code."""
    return _run('simulator', args)


def estimator(args=None):
    """Run estimator_node; return the exit code."""
    return _run('estimator', args)


def controller(args=None):
    """Run controller_node; return the exit code."""
    return _run('controller', args)
