"""Message stamps to seconds and back, without losing microseconds to large numbers."""

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


def time_message(nanoseconds):
    """Return integer nanoseconds since 1970 as a builtin_interfaces Time."""
    sec, nanosec = divmod(max(nanoseconds, 0), 10**9)
    return Time(sec=sec, nanosec=nanosec)
