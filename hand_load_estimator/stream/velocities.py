"""Velocities that a driver does not measure, and reports as zero."""

import numpy as np

# An arm whose positions go so far [rad] in such a time [s], every velocity zero, measures none.
GONE, TIME = 0.02, 1.0


class Velocities:
    """
    Take velocities that are all exactly zero for missing ones, where the arm moves.

    none: whether they are. An arm at rest may report such zeros, too: until it moves they count.
    """

    def __init__(self):
        self.none = False
        self.forget()

    def forget(self):
        """Begin anew where the arm was told to be elsewhere."""
        self._began = -np.inf, None

    def checked(self, stamp, signal, turns):
        """
        Return q, v, effort (3, n) at a stamp [s], with NaN for velocities that are none.

        turns (n,) or 0.0 [rad]: what q is behind of, of whole turns.
        """
        if np.count_nonzero(signal[1]):
            self.none, self._began = False, (-np.inf, None)
            return signal
        since, place = self._began
        if not 0.0 <= stamp - since <= TIME:
            self._began = stamp, signal[0] + turns
        elif not self.none:
            self.none = bool(np.abs(signal[0] + turns - place).max() > GONE)
        if self.none:
            signal[1] = np.nan
        return signal
