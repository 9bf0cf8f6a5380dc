"""Windows of the newest data, in which every sample may show that another load is held."""

from dataclasses import dataclass

import numpy as np

from .change import IN_TURN, log_bayes_factor, LONG, OF_A_MOMENT, SHORT, strongest_joint


@dataclass(frozen=True)
class Older:
    """
    What data older than a window say.

    mean (d,), precision (d, d) of load and nuisances; slip (10, 10): slip_covariance.
    """

    mean: np.ndarray
    precision: np.ndarray
    slip: np.ndarray


class ChangeWindows:
    """
    Test windows of RecentData against what is older; n joints.

    change (10, 10): covariance of what the products may change by with the load. A window begins
    some pieces back and grows with every sample; from time to time it is begun anew. Where the
    model has foretold the torques well, every sample is tested, also for a slip of the grasp, and
    no joint is suspected instead. Where it has not, what ails an arm looks like that, too often.
    """

    def __init__(self, change, recent, n):
        self._change, self._recent, self._joints = change, recent, n
        self._windows, self._needed, self._turn = {}, np.inf, 0

    def clear(self):
        """Forget all windows."""
        self._windows.clear()

    def take(self, piece):
        """Take the piece of Information that has just ended."""
        for recent, _ in self._windows.values():
            recent.add(piece)

    def begin(self, needed, older_of):
        """
        Begin windows anew where a piece has just ended: the short one, and another in turn.

        needed: evidence asked for [nats]; older_of(Information) -> Older.
        """
        self._turn, self._needed = (self._turn + 1) % len(IN_TURN), needed
        for count in (SHORT, IN_TURN[self._turn]):
            split = self._recent.split(count)
            if split is not None:
                self._windows[count] = split[1], older_of(split[0])

    def suspicious(self):
        """Tell whether the newest sample may show another load; for a model that foretells."""
        return any(self._suspicious(count) for count in self._windows if count != LONG)

    def changed(self, foretold, begun):
        """
        Tell whether another load is held.

        foretold: whether the model has foretold the torques well; begun: windows have just begun
        anew.
        """
        return (foretold or begun) and any(
            self._changed(count, foretold) for count in self._windows
            if count != LONG or begun and IN_TURN[self._turn] == LONG)

    def evidence(self, recent, older, foretold):
        """Return the log Bayes factor of another load, or of a slip, from Information, Older."""
        changes = (self._change, older.slip) if foretold else (self._change,)
        return max(log_bayes_factor(recent, older.mean, older.precision, change)
                   for change in changes)

    def _needed_of(self, count):
        return self._needed * (OF_A_MOMENT if count == SHORT else 1.0)

    def _suspicious(self, count):
        recent, older = self._windows[count]
        left = self._recent.with_open(recent).left_by(older.mean)
        # No log Bayes factor is larger than that.
        return 0.5 * left > self._needed_of(count)

    def _changed(self, count, foretold):
        if not self._suspicious(count):
            return False
        recent, older = self._windows[count]
        recent = self._recent.with_open(recent)
        evidence = self.evidence(recent, older, foretold)
        # A slip may show in one joint only. Where the model has foretold the torques that well,
        # a joint that suddenly is another is less likely still.
        return evidence > self._needed_of(count) and (foretold or evidence > strongest_joint(
            recent, older.mean, older.precision, self._joints))
