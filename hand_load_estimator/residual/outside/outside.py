"""What acted from outside in whole recordings, and what is left of them without it."""

from dataclasses import dataclass

import numpy as np

from ..doubts.limits import usable_residual
from .contact import contact
from .disturbance import around, Disturbances, inside, undisturbed
from .load_change import load_change
from .standing import is_held, Standing

# Without recordings to test on, the last part of every recording is kept for that.
TEST_SHARE = 0.25
# What is in these rows to this share is known already.
KNOWN = 0.5


@dataclass(frozen=True)
class Outside:
    """
    What acted from outside.

    shown: tuple of (Residual of whole recordings, Disturbance in it), in the order of time;
    rows (N,) bool: in any of them.
    """

    shown: tuple
    rows: np.ndarray

    @property
    def found(self):
        """The Disturbances."""
        return tuple(one for _, one in self.shown)

    def hidden(self, evidence, found):
        """Return those Disturbances of an arm that moves that are news."""
        return tuple(one for one in found if not is_held(evidence[one.owner])
                     and self.rows[one.first:one.stop].mean() < KNOWN)

    def joined(self, residual, found):
        """Return the Outside with Disturbances in a Residual of the same rows, too."""
        # What is mostly inside a new one was a part of it.
        apart = [pair for pair in self.shown if not any(
            inside(pair[1].first, pair[1].stop, one) for one in found)]
        shown = sorted((*apart, *((residual, one) for one in found)),
                       key=lambda pair: pair[1].first)
        return Outside(tuple(shown), self.rows | around(
            residual, [(one.first, one.stop) for one in found]))

    def left_out(self, evidence, residual):
        """Return the time [s] of it in the parts of whole recordings kept for the test."""
        seconds = 0.0
        for e, rows in zip(evidence, self._rows_of(evidence, residual)):
            done = np.cumsum(~rows) / max(np.sum(~rows), 1)
            seconds += float(e.motion.dt[rows & (done > 1.0 - TEST_SHARE)].sum())
        return seconds

    def parts(self, evidence, residual, test):
        """Return (Evidence to fit, Evidence to test on) without it; test: Evidence given."""
        rows = self._rows_of(evidence, residual)
        last = 1.0 if test else 1.0 - TEST_SHARE

        def parts(share):
            return tuple(part for e, r in zip(evidence, rows) for part in undisturbed(e, r, share))
        return parts((0.0, last)), tuple(test) or parts((last, 1.0))

    def _rows_of(self, evidence, residual):
        """Return for each recording its rows (M,) bool."""
        return [self.rows[residual.owner == k] for k in range(len(evidence))]


def outside_of(model, evidence, residual):
    """Return the Outside that a TorqueModel shows in a Residual of whole recordings, Evidence."""
    nothing = Outside((), np.zeros(len(residual.dt), dtype=bool))
    standing = nothing.joined(residual, Standing(model, evidence, residual).found)
    moving = _in_motion(model, evidence, residual)
    return standing.joined(residual, nothing.hidden(evidence, moving))


def outside_again(better, evidence):
    """Return the Residual of whole recordings by a better TorqueModel, Disturbances in it."""
    residual, _ = usable_residual(better, evidence)
    return residual, _in_motion(better, evidence, residual)


def _in_motion(model, evidence, residual):
    """Return the Disturbances of an arm that moves."""
    loads = tuple(e.load for e in evidence)
    return Disturbances(model, residual, (contact(model.robot, residual),
                                          load_change(model.robot, residual, loads))).found
