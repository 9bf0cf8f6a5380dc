"""Let through what comes too often at a given rate."""


class Throttle:
    """
    Tell for each arrival whether it is due.

    The rate [Hz] holds on average: where arrivals are about as frequent as the rate, jitter of
    their times makes none of them fall out.
    """

    def __init__(self, rate):
        self.rate = rate
        self._next = None

    def due(self, now):
        """Return True when what arrives at `now` [s] is to go through."""
        period = 1.0 / self.rate
        if self._next is None or now < self._next - 2.0 * period:  # first, or the clock went back
            self._next = now
        if now < self._next:
            return False
        self._next = max(self._next + period, now)
        return True
