"""SIGINT and SIGTERM as a wish that is kept until the node can follow it."""

import signal
import time

# A second signal this long [s] after the first ends a node that hangs. An earlier one is the same
# wish told twice, as by a terminal and `ros2 launch` both, and must not cut a braking arm short.
_PATIENCE = 1.0
_stop = []


def _handle(number, _frame):
    now = time.monotonic()
    if _stop and now - _stop[0] > _PATIENCE:
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)
    _stop.append(now)


def heed_signals():
    """
    Take over SIGINT and SIGTERM, at the first call and again at later ones.

    Return the list that becomes non-empty at the first of them: its time [s].
    """
    signal.signal(signal.SIGINT, _handle)
    signal.signal(signal.SIGTERM, _handle)
    return _stop
