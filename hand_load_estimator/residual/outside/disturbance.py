"""Disturbances: what acts on the arm from outside for a time."""

from dataclasses import dataclass, replace

import numpy as np

from ...motion import DELAY
from .interval import edge_curve, evidence_of_any_size, fit, Kind, Search
from .usual import Usual

# Nats to be gained beyond the logarithm of the intervals tried.
LEAST_EVIDENCE = 25.0
MOST = 16
# A cause must explain this share of the residual in its time, and of what a free step of every
# joint does.
EXPLAINED = 0.6
# A disturbance has so many times the evidence of the best of what is left beside it.
STANDS_OUT = 3.0
# Two causes this close [nats] are not told apart.
TIE = 5.0
# Rise of a push and the filter's memory [s]: rows so near an edge belong to neither side.
LEFT_OUT = 0.1
# What edges are known to at best [s]: nobody knows how fast a push rises.
EDGE_STD = 0.02
NEAR = 0.8                 # [s] within which an edge is looked for row by row
# Nothing is looked for in recordings shorter than this [s], and no shorter parts are kept.
SHORTEST_RECORDING, SHORTEST_PART = 3.0, 1.0
# Size of a free step, in units of the joint's torque limit.
STEP = 0.1


@dataclass(frozen=True)
class Cause:
    """A Kind of disturbance; possible(parameters, covariance, owner) tells what physics allows."""

    kind: Kind
    possible: object


@dataclass(frozen=True)
class Disturbance:
    """
    One disturbance: its Cause, rows first..stop of recording `owner`, theta (k,) and covariance.

    theta in physical units; start, end: (time, std) [s] from the recording's first sample, None
    where it lasts from the start or to the end; evidence, needed [nats]; tried: intervals;
    rival, margin [nats]: the next best explanation of the same time, by evidence_of_any_size;
    explained (n,): share of each joint's residual in that time.
    """

    cause: Cause
    owner: int
    first: int
    stop: int
    theta: np.ndarray
    covariance: np.ndarray
    start: tuple | None
    end: tuple | None
    evidence: float
    needed: float
    tried: int
    rival: str | None
    margin: float | None
    explained: np.ndarray | None = None


class Disturbances:
    """
    Search for Disturbances by some Causes in a Residual of a TorqueModel.

    found: tuple of Disturbance in the order of time.
    """

    def __init__(self, model, residual, causes):
        self._residual, self._causes = residual, causes
        self._usual = Usual(model, residual)
        self._dt = float(np.median(residual.dt))
        owned = [np.flatnonzero(residual.owner == k) for k in np.unique(residual.owner)]
        self._recordings = [slice(int(rows[0]), int(rows[-1]) + 1) for rows in owned
                            if residual.dt[rows].sum() > SHORTEST_RECORDING]
        n = model.robot.n
        step = np.broadcast_to(np.eye(n), (len(residual.dt), n, n))
        self._steps = Kind('step', step * STEP * model.robot.limits.torque[:, None],
                           np.ones(n), 0.0, 0.0, 0.0, False)
        self.tried = 0
        measured = self._measured(self._select())
        self.found = tuple(sorted(self._sure(measured), key=lambda found: found.first))

    def _select(self):
        """Return (first, stop, evidence) of what may be disturbances, the likeliest first."""
        taken = []
        while len(taken) < MOST:
            likeliest = self._likeliest(self._searches())
            if likeliest is None:
                break
            taken.append(likeliest[1:])
            self._leave_out(taken)
        return taken

    def _searches(self):
        return {cause.kind.name: Search(self._usual, cause.kind, self._recordings, self._dt)
                for cause in self._causes}

    def _likeliest(self, searches):
        """Return (Cause, first, stop, evidence) of the likeliest disturbance, or None."""
        found = []
        for cause in self._causes:
            search = searches[cause.kind.name]
            interval = search.best()
            self.tried = max(self.tried, search.tried)
            if interval is None:
                continue
            found += self._explanations(*interval[1:], (cause,))
        return max(found, key=lambda one: one[3], default=None)

    def _explanations(self, first, stop, causes):
        """Return the (Cause, first, stop, evidence) of the causes that explain an interval."""
        least = max(self._needed(), EXPLAINED * fit(self._usual, self._steps, first, stop)[0])
        found = []
        for cause in causes:
            if not self._lasts(cause.kind, first, stop):
                continue
            evidence, theta, covariance = fit(self._usual, cause.kind, first, stop)
            if evidence > least and self._possible(cause, theta, covariance, first):
                found.append((cause, first, stop, evidence))
        return found

    def _lasts(self, kind, first, stop):
        """Tell whether a Kind may act as long as an interval."""
        rows = next(rows for rows in self._recordings if first < rows.stop)
        most = 1.0 if kind.open_ended else kind.longest
        return self._seconds(first, stop) >= 0.9 * kind.shortest \
            and stop - first <= most * (rows.stop - rows.start)

    def _possible(self, cause, theta, covariance, first):
        scale = cause.kind.scale
        return cause.possible(theta * scale, covariance * np.outer(scale, scale),
                              int(self._residual.owner[first]))

    def _needed(self):
        return LEAST_EVIDENCE + np.log(max(self.tried, 1))

    def _seconds(self, first, stop):
        return float(self._residual.dt[first:stop].sum())

    def _leave_out(self, spans):
        rows = around(self._residual, [span[:2] for span in spans])
        self._usual.fit(np.where(rows[:, None], 0.0, self._residual.weights))

    def _measured(self, spans):
        """Return the Disturbances of spans; of what overlaps, the stronger."""
        left, found = sorted(spans, key=lambda span: -span[2]), []
        while left:
            span, *left = left
            # What touches it may be the rest of it.
            apart = [other for other in left if not self._touch(span, other)]
            one = self._one(*span[:2], [*((d.first, d.stop) for d in found), *apart])
            if one is not None:
                found.append(one)
                left = [other for other in left if not inside(*other[:2], one)]
        return found

    def _touch(self, span, other):
        gap = NEAR / self._dt
        return other[0] < span[1] + gap and span[0] < other[1] + gap

    def _one(self, first, stop, others):
        """Return the Disturbance at an interval, its edges where they fit best, or None."""
        self._leave_out(others)
        found = []
        for cause, search in zip(self._causes, self._searches().values()):
            found += self._explanations(*search.moved(first, stop)[1:], (cause,))
        if not found:
            return None
        cause, first, stop, _ = max(found, key=lambda one: one[3])
        rows = next(rows for rows in self._recordings if first < rows.stop)
        edges = [0.0, 0.0]
        for at_first in (True, False):
            edge, std = self._edge(cause.kind, rows, first, stop, at_first)
            first, stop = (edge, stop) if at_first else (first, edge)
            edges[not at_first] = std
        # With its edges where they are, another cause may explain it better.
        (likeliest, cause), rival, evidence = self._ranked(cause, first, stop)
        theta, covariance = self._size(cause.kind, first, stop, others)
        start, end = (self._time(rows, edge, std) for edge, std in zip((first, stop), edges))
        return Disturbance(cause, int(self._residual.owner[first]), first, stop, theta, covariance,
                           start, end, evidence, self._needed(), self.tried,
                           rival and rival[1].kind.name, rival and likeliest - rival[0])

    def _ranked(self, cause, first, stop):
        """
        Return the likeliest (evidence of any size, Cause) of an interval, and the next or None.

        And the evidence that something happened at all, whatever it was.
        """
        others = self._explanations(first, stop, [c for c in self._causes if c is not cause])
        causes = [cause, *(other for other, *_ in others)]
        ranked = sorted(((evidence_of_any_size(self._usual, c.kind, first, stop), c)
                         for c in causes), key=lambda pair: -pair[0])
        return ranked[0], next(iter(ranked[1:]), None), max(
            fit(self._usual, c.kind, first, stop)[0] for c in causes)

    def _sure(self, found):
        """Return the Disturbances that stand out of what is left when all are left out."""
        self._leave_out([(d.first, d.stop) for d in found])
        searches = self._searches()
        others = max((self._left_in(search) for search in searches.values()), default=0.0)
        out = []
        for one in sorted(found, key=lambda one: one.evidence):
            search = searches[one.cause.kind.name]
            # A push also changes what friction holds, which no quiet time shows: never below one.
            excess = max(search.excess(self._seconds(one.first, one.stop)), 1.0)
            explained, share = self._share(one)
            if one.evidence > max(excess * one.needed, STANDS_OUT * others) \
                    and share > EXPLAINED and self._plausible(one, excess):
                out.append(replace(one, covariance=excess * one.covariance, explained=explained,
                                   evidence=one.evidence / excess,
                                   margin=one.margin and one.margin / excess))
            else:
                # Where bursts as strong are no disturbance, something goes on all the time.
                others = max(others, one.evidence)
        return out

    def _left_in(self, search):
        interval = search.best()
        return fit(self._usual, search.kind, *interval[1:])[0] if interval else 0.0

    def _plausible(self, one, excess):
        return self._seconds(one.first, one.stop) > 0.9 * one.cause.kind.shortest \
            and one.cause.possible(one.theta, excess * one.covariance, one.owner)

    def _share(self, one):
        """Return the share of each joint's residual (n,) that a Disturbance explains, of all's."""
        inner = int(round(LEFT_OUT / self._dt))
        rows = slice(one.first + inner, max(one.stop - inner, one.first + inner + 1))
        torque = one.cause.kind.columns[rows] @ (one.theta / one.cause.kind.scale)
        weights, rest = self._residual.weights[rows], self._usual.rest[rows]
        whole = (weights * rest ** 2).sum(axis=0)
        left = (weights * (rest - torque) ** 2).sum(axis=0)
        return (np.clip(1.0 - left / np.maximum(whole, 1e-12), 0.0, 1.0),
                1.0 - left.sum() / max(whole.sum(), 1e-12))

    def _edge(self, kind, rows, first, stop, at_first):
        """Return the likeliest row of an edge and its standard deviation [s]."""
        near = int(round(NEAR / self._dt))
        places, evidence = edge_curve(self._usual, kind, rows, first, stop, at_first, near)
        chance = np.exp(evidence - evidence.max())
        chance /= chance.sum()
        middle = chance @ places
        spread = np.sqrt(chance @ (places - middle) ** 2) * self._dt
        return int(places[np.argmax(evidence)]), float(np.hypot(spread, EDGE_STD))

    def _time(self, rows, edge, std):
        """Return (time, std) [s] of an edge, None at an end of the recording."""
        if edge - rows.start < NEAR / self._dt / 4 or rows.stop - edge < NEAR / self._dt / 4:
            return None
        stamp = self._residual.time
        return float(stamp[edge] - 0.5 * self._dt - DELAY - stamp[rows.start]), std

    def _size(self, kind, first, stop, others):
        """Return theta and covariance in physical units, from rows where all of it acts."""
        # Not even what is usual may see the rise of a push, or it would take part of it.
        self._leave_out([*others, (first, first), (stop, stop)])
        _, theta, covariance = fit(self._usual, kind, first, stop)
        return theta * kind.scale, covariance * np.outer(kind.scale, kind.scale)


def inside(first, stop, one):
    """Tell whether a Disturbance covers most of the rows first..stop."""
    return min(stop, one.stop) - max(first, one.first) > 0.5 * (stop - first)


def around(residual, spans):
    """Return the rows (N,) bool of a Residual within spans (first, stop) and a little around."""
    more = int(round(LEFT_OUT / float(np.median(residual.dt))))
    rows = np.zeros(len(residual.dt), dtype=bool)
    for first, stop in spans:
        rows[max(first - more, 0):stop + more] = True
    return rows


def undisturbed(evidence, rows, share=(0.0, 1.0)):
    """
    Return the parts of one recording's Evidence without rows (N,) bool, as Evidence each.

    share: from where to where of what remains.
    """
    keep = ~rows
    done = np.cumsum(keep) / max(keep.sum(), 1)
    keep &= (done > share[0]) & (done <= share[1])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], keep.astype(int), [0]])))
    spans = [slice(a, b) for a, b in zip(edges[::2], edges[1::2])]
    lengths = [evidence.motion.dt[span].sum() for span in spans]
    # The longest is kept however short it is, so that something of every recording is left.
    return [evidence.part(span) for span, length in zip(spans, lengths)
            if length >= min(SHORTEST_PART, max(lengths))]
