"""What belongs to a torque that is reported late: rows of a load, doubt about friction."""

from collections import deque

import numpy as np


class LateRows:
    """
    Remember rows (n, k), one per joint, along a stream, as far back as a delay may reach.

    delays {joint: (share, seconds)}: of the joint's torque that share comes so much later.
    """

    def __init__(self, delays):
        self._delays = delays
        self._longest = max((seconds for _, seconds in delays.values()), default=0.0)
        self.restart()

    def restart(self):
        """Forget what was; before the first rows everything stood still."""
        self._past, self._time = deque(), 0.0

    def change(self, rows, dt):
        """Return (n, k): what the delays add to rows (n, k), dt [s] after the last."""
        out = np.zeros_like(rows)
        if not self._delays:
            return out
        self._time += dt
        self._past.append((self._time, rows))
        while len(self._past) > 1 and self._past[1][0] <= self._time - self._longest:
            self._past.popleft()
        for joint, (share, seconds) in self._delays.items():
            out[joint] = share * (self._ago(joint, seconds) - rows[joint])
        return out

    def _ago(self, joint, seconds):
        """Return the joint's row (k,) so many seconds ago, on straight lines between."""
        then = self._time - seconds
        before = at = self._past[0]
        for at in self._past:
            if at[0] >= then:
                break
            before = at
        span = at[0] - before[0]
        share = (then - before[0]) / span if span > 0.0 else 0.0
        return before[1][joint] + share * (at[1][joint] - before[1][joint])
