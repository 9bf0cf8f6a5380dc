"""Velocities that a driver does not measure, and reports as zero."""

import numpy as np

# A joint whose position goes so far [rad] in such a time [s], its velocity zero, measures none.
GONE, TIME = 0.05, 1.0
# What it did while nothing was heard for so long [s] its velocity need not tell.
LOST = 0.1


class Velocities:
    """
    Take velocities for missing ones where one of them is exactly zero while its joint moves.

    stuck (n,): which are; some: whether there are any. A joint at rest may report such zeros,
    too: until it moves they count.
    """

    def __init__(self, n):
        self._n = n
        self.forget()

    def forget(self):
        """Begin anew where the arm was told to be elsewhere."""
        self.stuck, self.some = np.zeros(self._n, dtype=bool), False
        self._place = None

    def checked(self, stamp, signal, turns):
        """
        Return q, v, effort (3, n) at a stamp [s], with NaN for velocities that are none.

        turns (n,) or 0.0 [rad]: what q is behind of, of whole turns.
        """
        if np.count_nonzero(signal[1]) == self._n:
            if self._place is not None:
                self.forget()
            return signal
        zero, q = signal[1] == 0.0, signal[0] + turns
        if self._place is None:
            self._since, self._place, self._heard = np.full(self._n, stamp), q, stamp
        ago = stamp - self._since
        lasts = zero & (0.0 <= ago) & (ago <= TIME) & (stamp - self._heard <= LOST)
        self._heard = stamp
        self.stuck = zero & (self.stuck | lasts & (np.abs(q - self._place) > GONE))
        # An arm that moves and reports nothing but zeros measures no velocity at all.
        if zero.all() and self.stuck.any():
            self.stuck = zero
        self._since = np.where(lasts, self._since, stamp)
        self._place = np.where(lasts, self._place, q)
        self.some = bool(self.stuck.any())
        if self.some:
            signal[1, self.stuck] = np.nan
        return signal
