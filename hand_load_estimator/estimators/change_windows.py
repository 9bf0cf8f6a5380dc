"""Windows of the newest data, in which every sample may show that another load is held."""

from dataclasses import dataclass

import numpy as np

from .change import (BRIEF, expected_ahead, FORETOLD, log_bayes_factor, LONG, MIDDLE,
                     OF_A_MOMENT, OF_EXPECTED, SHORT, strongest_joint)
from .information import Posterior


@dataclass(frozen=True)
class Older:
    """
    What data older than a window say.

    mean (d,), precision (d, d) of load and nuisances; slip (10, 10): slip_covariance; load: the
    Posterior of the load, as the model states.
    """

    mean: np.ndarray
    precision: np.ndarray
    slip: np.ndarray
    load: Posterior


class ChangeWindows:
    """
    Test windows of RecentData against what is older; n joints.

    change (10, 10): covariance of what the products may change by with the load. A window begins
    some pieces back and grows with every sample, until it is begun anew. Where the model has
    foretold the torques well, less evidence is asked for unless a joint explains as much, every
    sample is tested, also for a slip of the grasp, in one window more, and the longest one for
    small changes. Elsewhere what ails an arm looks like another load the more often, the more is
    tested, and another load has to be ahead of any one joint by the evidence asked for, or by
    OF_EXPECTED of what one would be.
    """

    def __init__(self, change, recent, n):
        self._change, self._recent, self._joints = change, recent, n
        self._needed, self._turn = np.inf, 0
        self.clear()

    def clear(self):
        """Forget all windows."""
        self._windows, self._begun, self._foretold = {}, [], False

    def take(self, piece):
        """Take the piece of Information that has just ended."""
        for recent, _ in self._windows.values():
            recent.add(piece)

    def begin(self, needed, older_of, foretold):
        """
        Begin windows anew where a piece has just ended: the short ones, and another in turn.

        needed: evidence asked for of a model that does not foretell [nats];
        older_of(Information) -> Older; foretold: whether the model has foretold the torques well.
        """
        self._needed, self._turn, self._foretold = needed, 1 - self._turn, foretold
        if foretold:
            due = SHORT, BRIEF, (MIDDLE, LONG)[self._turn]
        else:
            due = ((SHORT, MIDDLE), (SHORT,))[self._turn]
        splits = {count: self._recent.split(count) for count in due}
        self._begun = [count for count, split in splits.items() if split is not None]
        # One belief for the two shortest: once there was some motion, the piece between tells
        # next to nothing.
        shortest = BRIEF if BRIEF in self._begun else SHORT
        older = {count: older_of(splits[count][0]) for count in self._begun if count >= shortest}
        self._windows.update({count: (splits[count][1], older[max(count, shortest)])
                              for count in self._begun})

    def changed_by_sample(self):
        """Tell whether the newest sample shows another load, of a model that foretells."""
        return self._foretold and any(self._changed(count) for count in self._windows
                                      if count != LONG)

    def changed_by_pieces(self):
        """Tell whether the windows that have just begun show another load."""
        return any(self._changed(count) for count in self._begun)

    def evidence(self, recent, older):
        """Return the log Bayes factor of another load, or of a slip, from Information, Older."""
        changes = (self._change, older.slip) if self._foretold else (self._change,)
        return max(log_bayes_factor(recent, older.mean, older.precision, change)
                   for change in changes)

    def _changed(self, count):
        recent, older = self._windows[count]
        recent = self._recent.with_open(recent)
        needed = self._needed * (OF_A_MOMENT if count == SHORT else 1.0)
        least = needed * (FORETOLD if self._foretold else 1.0)
        # No log Bayes factor is larger than that.
        if 0.5 * recent.left_by(older.mean) <= least:
            return False
        evidence = self.evidence(recent, older)
        if evidence <= least:
            return False
        # Most of what ails an arm shows in one joint, but so may a slip: of a model that has
        # foretold the torques well all the evidence suffices, whatever a joint explains.
        if self._foretold and evidence > needed:
            return True
        belief = older.mean, older.precision
        ahead = evidence - strongest_joint(recent, *belief, self._joints)
        if ahead <= 0.0 or self._foretold:
            return ahead > 0.0
        expected = expected_ahead(recent, *belief, self._change, self._joints)
        return ahead > min(self._needed, OF_EXPECTED * expected)
