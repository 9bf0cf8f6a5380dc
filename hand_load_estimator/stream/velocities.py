"""Velocities that a driver does not measure, and reports as zero."""

import numpy as np

# A joint whose position goes so far [rad] in such a time [s], its velocity zero, measures none.
GONE, TIME = 0.02, 1.0


class Velocities:
    """
    Take velocities for missing ones where one of them is exactly zero while its joint moves.

    stuck (n,): which are. A joint at rest may report such zeros, too: until it moves they count.
    All count as missing where one does: the motion filter has all velocities, or none.
    """

    def __init__(self, n):
        self._n = n
        self.forget()

    def forget(self):
        """Begin anew where the arm was told to be elsewhere."""
        self.stuck, self._place = np.zeros(self._n, dtype=bool), None

    def checked(self, stamp, signal, turns):
        """
        Return q, v, effort (3, n) at a stamp [s], with NaN for velocities where they are none.

        turns (n,) or 0.0 [rad]: what q is behind of, of whole turns.
        """
        if np.count_nonzero(signal[1]) == self._n:
            if self._place is not None:
                self.forget()
            return signal
        zero, q = signal[1] == 0.0, signal[0] + turns
        if self._place is None:
            self._since, self._place = np.full(self._n, stamp), q
        ago = stamp - self._since
        lasts = zero & (0.0 <= ago) & (ago <= TIME)
        self.stuck = zero & (self.stuck | lasts & (np.abs(q - self._place) > GONE))
        # An arm that moves and reports nothing but zeros measures no velocity at all.
        if zero.all() and self.stuck.any():
            self.stuck = zero
        self._since = np.where(lasts, self._since, stamp)
        self._place = np.where(lasts, self._place, q)
        if self.stuck.any():
            signal[1] = np.nan
        return signal
