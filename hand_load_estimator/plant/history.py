"""The last reported torques, for effort that comes late against position."""

import numpy as np


class History:
    """
    Delay torque (n,) by `delay` (n,) [s] each, linear between the steps of dt [s].

    Without delays it passes the present value through.
    """

    def __init__(self, delay, dt, torque):
        behind = np.asarray(delay, dtype=float) / dt
        self._whole = np.floor(behind).astype(int)
        self._part = behind - self._whole
        self._length = int(self._whole.max()) + 2
        self._columns = np.arange(len(behind))
        self._ring = np.tile(torque, (self._length, 1))
        self._now = 0
        self._active = bool(np.any(behind > 0.0))
        self._present = torque

    def add(self, torque):
        """Take the torque (n,) of the next step; without delays it must be the same array."""
        self._present = torque
        if self._active:
            self._now = (self._now + 1) % self._length
            self._ring[self._now] = torque

    def delayed(self):
        """Return the delayed torque (n,)."""
        if not self._active:
            return self._present
        row = (self._now - self._whole) % self._length
        later, earlier = self._ring[row, self._columns], \
            self._ring[(row - 1) % self._length, self._columns]
        return later + self._part * (earlier - later)
