"""Message stamps to seconds and back, without losing microseconds to large numbers."""

import math

from builtin_interfaces.msg import Time


class StampBase:
    """
    Seconds since a whole second near the first stamp seen.

    Seconds since 1970 in a float resolve 0.24 us, too coarse beside a 1 ms sample time; counted
    from a nearby second they are exact.
    """

    def __init__(self):
        self._origin = None

    def seconds(self, stamp):
        """Return a builtin_interfaces Time as seconds since the origin."""
        if self._origin is None:
            self._origin = stamp.sec
        return (stamp.sec - self._origin) + 1e-9 * stamp.nanosec

    def message(self, seconds):
        """Return seconds since the origin as a builtin_interfaces Time."""
        return time_message(int(round(seconds * 1e9)) + (self._origin or 0) * 10**9)


class ClockOffset:
    """
    What this node's clock is ahead of the clock that stamps the joint states.

    The smallest offset of the last second or two is that of a message that came at once; what is
    above it has waited. What was longer ago counts no more: clocks run apart, and jump.
    """

    KEPT = 1.0  # [s]
    SET = 0.03  # [s] by which it must have gone beside a steady clock to have been set

    def __init__(self):
        self.restart()

    def restart(self):
        """Begin anew, as after a jump of either clock."""
        self._since, self._before, self._least = None, math.inf, 0.0
        self._beside = None

    def update(self, now, stamp, steady=None):
        """
        Take a stamp [s] that arrived at `now` [s]; return it in this node's time [s].

        steady [s]: a clock that nobody sets, by which a clock that was is told from a delay.
        """
        if steady is not None:
            if self._beside is not None and abs(now - steady - self._beside) > self.SET:
                self.restart()
            self._beside = now - steady
        seen = now - stamp
        if self._since is None:
            self._since, self._least = now, seen
        elif not 0.0 <= now - self._since < self.KEPT:
            self._since, self._before, self._least = now, self._least, seen
        self._least = min(self._least, seen)
        return self.here(stamp)

    def here(self, stamp):
        """Return a stamp [s] in this node's time [s]."""
        return stamp + min(self._before, self._least)


def time_message(nanoseconds):
    """Return integer nanoseconds since 1970 as a builtin_interfaces Time."""
    sec, nanosec = divmod(max(nanoseconds, 0), 10**9)
    return Time(sec=sec, nanosec=nanosec)
