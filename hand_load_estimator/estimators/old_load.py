"""What belongs to the load before a change, should that turn out to have been a contact."""

from dataclasses import dataclass

import numpy as np

from .information import Information
from .load_prior import LoadPrior

# A change is taken back when it turns out within so long [s] to have been a contact, and not twice
# within so long.
TAKEN_BACK, NOT_TWICE = 1.5, 5.0
# Nor, where a push was told, within so long [s]: longer than a contact is kept out, or one that
# does not end would never be let through.
NO_OTHER_PUSH = 15.0
# One that explains torques again which the newer does not comes back within so long [s], whatever
# was before: contacts are not left out any longer.
AGAIN = 10.0


@dataclass(frozen=True)
class OldLoad:
    """
    A load that was held.

    data: what was measured of it; start: shape (10,) at which its posterior is looked for;
    expected: LoadPrior before the data; trust: state of the ModelTrust beside it.
    """

    data: Information
    start: np.ndarray
    expected: LoadPrior
    trust: dict


class OldLoads:
    """Keep the OldLoad of the newest change; tell whether it may come back."""

    def __init__(self):
        self._kept = None
        self._changed = self._changed_before = self._returned = -np.inf

    def keep(self, stamp, load):
        """Keep the OldLoad of a change at a stamp [s]."""
        self._kept = load
        self._changed_before, self._changed = self._changed, stamp

    def forget(self):
        """Let none come back."""
        self._kept = None

    def back(self, stamp, surely, ails):
        """
        Return the OldLoad that comes back at a stamp [s], None where the newest change is let be.

        What looked like another load has turned out to be a contact, surely so or not. A load that
        was taken back just before and comes again is let be; where it is sure, so is one that
        comes soon after any change, whose load the model may misread, and any by a model that
        ails, because what ails an arm looks like pushes, too.
        """
        if self._kept is None or not 0.0 <= stamp - self._changed < TAKEN_BACK:
            return None
        if self._soon_after(self._returned, NO_OTHER_PUSH if surely else NOT_TWICE):
            return None
        if surely and (ails or self._soon_after(self._changed_before, NOT_TWICE)):
            return None
        return self._come_back(stamp)

    def again(self, stamp):
        """Return the OldLoad that torques are of again at a stamp [s], None where it is not."""
        if self._kept is None or not 0.0 <= stamp - self._changed < AGAIN:
            return None
        return self._come_back(stamp)

    def _come_back(self, stamp):
        load, self._kept = self._kept, None
        self._returned = self._changed = stamp
        return load

    def _soon_after(self, stamp, seconds):
        return 0.0 <= self._changed - stamp < seconds
