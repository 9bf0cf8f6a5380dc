"""Positions as commanded, brought to the moment at which the arm is there (E1.2)."""

from collections import deque

import numpy as np


class CommandedPositions:
    """
    Hold positions and velocities back by `lag` [s], efforts not: the arm follows that much later.

    Between messages the commands move on straight lines; before the first one they stood.
    """

    def __init__(self, lag):
        self._lag = lag
        self.restart()

    def restart(self):
        """Forget the commands."""
        self._past = deque()

    def update(self, stamp, signal):
        """Return q, v, effort (3, n) of the arm at a stamp [s], for those of the message."""
        self._past.append((stamp, signal[:2]))
        then = stamp - self._lag
        # One command older than the moment asked for is what the line begins at.
        while len(self._past) > 1 and self._past[1][0] <= then:
            self._past.popleft()
        first, before = self._past[0]
        second, after = self._past[min(1, len(self._past) - 1)]
        share = np.clip((then - first) / (second - first), 0.0, 1.0) if second > first else 0.0
        return np.concatenate([before + share * (after - before), signal[2:]])
