"""Run one node as a process: start, spin, stop cleanly."""

import gc
import sys

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from ..errors import ConfigurationError
from .signals import heed_signals

try:
    from rclpy.experimental.events_executor import EventsExecutor
except ImportError:
    # Early releases of Jazzy lack it; the node works, at 1.6 times the processor time.
    EventsExecutor = SingleThreadedExecutor

_STOP_LATENCY = 0.1  # [s] longest time a signal waits while no message wakes the node


def _start(make_node, args):
    """Return the node; ConfigurationError when arguments, files or parameters are wrong."""
    try:
        # rclpy's own handlers would end communication before `stop()` can send a last message.
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        return make_node()
    except (RuntimeError, ValueError, ParameterException) as error:
        # rcl reports unreadable parameter files, bad --ros-args and types of its own this way.
        if type(error).__module__.startswith('rclpy') or 'rcl' in type(error).__name__.lower():
            reason = ' '.join(str(error).split())
            raise ConfigurationError('--ros-args', f'is not usable ({reason})') from None
        raise


def _spin(node, stop):
    executor = EventsExecutor()
    executor.add_node(node)
    try:
        while not stop and rclpy.ok():
            executor.spin_once(_STOP_LATENCY)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.remove_node(node)
        executor.shutdown()


def run_node(make_node, args=None):
    """
    Run the node `make_node()` returns until SIGINT, SIGTERM or a shutdown; return the exit code.

    0: stopped cleanly; 2: wrong configuration, told in one sentence on stderr. A node with a
    method `stop()` has it called before it is destroyed, while it can still publish.
    """
    stop = heed_signals()
    node = None
    try:
        node = _start(make_node, args)
        # What is there now stays: without this, each full collection looks at all of it again and
        # holds the node up for tens of milliseconds.
        gc.collect()
        gc.freeze()
        _spin(node, stop)
    except ConfigurationError as error:
        print(f'error: {error}', file=sys.stderr)
        return 2
    finally:
        # Also after a fault of its own: an arm under way must not be left to its last trajectory.
        if hasattr(node, 'stop') and rclpy.ok():
            node.stop()
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
