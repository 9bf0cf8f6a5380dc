"""Where the arm was last seen, how fast, and how long ago."""

import numpy as np

_AT_REST = 0.1           # [rad/s] faster: somebody moves the arm
_MOVES = 0.05            # [rad/s] faster: a motion that tells of a load (DESIGN section 6)
_FRESH = 0.05            # [s] older joint states do not tell where a moving arm is
_TIMEOUT = 0.5           # [s] without joint states: they have stopped


class MeasuredState:
    """
    Position q (n,) [rad] and velocity v (n,) [rad/s], NaN where unknown; None before any.

    count: joint states taken.
    """

    def __init__(self):
        self.q = self.v = None
        self._at = self._earlier = None
        self._speeds = self._apart = None
        self.count = 0

    def take(self, now, q, v):
        """Take q and v measured at `now` [s]."""
        self.q, self.v, self._at = q, v, now
        self.count += 1
        unknown, self._speeds = np.isnan(v), np.abs(v)
        if unknown.any():
            self._tell_apart(now, q)
            self._speeds = np.where(unknown, self._apart, self._speeds)

    def _tell_apart(self, now, q):
        """Tell by positions some time apart how fast joints are whose velocity is unknown."""
        if self._earlier is None or not 0.0 <= now - self._earlier[0] < _TIMEOUT:
            self._earlier, self._apart = (now, q), np.full(len(q), np.inf)
        elif now - self._earlier[0] >= _FRESH:
            moved = np.abs(q - self._earlier[1])
            self._earlier, self._apart = (now, q), moved / (now - self._earlier[0])

    def at(self, now):
        """Return where the arm is by now (n,), should its velocity be known and still hold."""
        return self.q + np.nan_to_num(self.v) * self._age(now)

    def fresh(self, now):
        """Tell whether it says where a moving arm is."""
        return self._age(now) <= _FRESH

    def stopped(self, now):
        """Tell whether no joint states come any more."""
        return self._age(now) > _TIMEOUT

    def moves(self, now, joints):
        """Tell whether one of joints (n,) bool is known to move."""
        if not self.fresh(now):
            return False
        speeds = self._speeds[joints]
        return bool(((speeds > _MOVES) & (speeds < np.inf)).any())

    def rests(self, now):
        """Tell whether the arm is known to stand."""
        return not self.stopped(now) and self._speeds.max() < _AT_REST

    def clock_went(self, now, step):
        """Count what was measured on the clock before it went by step [s] to `now`."""
        if self._at is not None and abs(now - self._at - step) < self._age(now):
            self._at += step

    def _age(self, now):
        # Ahead of a clock that went back is old, too.
        return abs(now - self._at)
