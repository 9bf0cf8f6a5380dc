"""Find the interval of time in which some columns act on the arm, and how sure that is."""

from dataclasses import dataclass

import numpy as np

# Factor between the lengths of intervals that are first tried.
LADDER = 1.4
# An interval tells something of its columns from so many degrees of freedom on.
TOLD = 1.0
# Median of chi^2 over its degrees of freedom, for a few of them.
MEDIAN = 0.8
# How strong something acts, in units of its scale, where nobody knows: as likely each of these.
SIZES = 0.25 ** np.arange(5)


@dataclass(frozen=True)
class Kind:
    """
    What may act for a time: columns (N, n, k) in units of scale (k,), torque = columns @ theta.

    cell [s]: between times first tried; shortest [s]; longest: share of a recording; open_ended:
    whether it may also last from a recording's start, or to its end.
    """

    name: str
    columns: np.ndarray
    scale: np.ndarray
    cell: float
    shortest: float
    longest: float
    open_ended: bool


class Sums:
    """Information (..., k, k) and gradient (..., k) of a Kind, for sums over rows."""

    def __init__(self, usual, kind, rows, size=1):
        """rows: slice; size: rows that are summed to one entry."""
        count = (rows.stop - rows.start) // size
        rows = slice(rows.start, rows.start + count * size)
        columns, w = kind.columns[rows], usual.weights[rows]
        n, k = columns.shape[1:]
        weighted = columns * w[:, :, None]
        cells = weighted.reshape(count, size * n, k)
        self.matrix = _summed(np.swapaxes(cells, 1, 2) @ columns.reshape(count, size * n, k))
        rest = usual.rest[rows].reshape(count, size * n, 1)
        self.vector = _summed((np.swapaxes(cells, 1, 2) @ rest)[..., 0])
        basis = usual.basis[rows].reshape(count, size, n, -1).transpose(0, 2, 3, 1)
        cross = basis @ weighted.reshape(count, size, n, k).transpose(0, 2, 1, 3)
        self.cross = _summed(cross.reshape(count, -1, k))

    def between(self, first, stop):
        """Return information (m, k, k), gradient (m, k) from entries `first` to `stop` (m,)."""
        return told(*(part[stop] - part[first] for part in
                      (self.matrix, self.vector, self.cross)))


def told(matrix, vector, cross):
    """Return information and gradient beside refitted nuisances, from sums over rows."""
    return matrix - np.swapaxes(cross, -1, -2) @ cross, vector


def _summed(parts):
    return np.concatenate([np.zeros((1, *parts.shape[1:])), np.cumsum(parts, axis=0)])


def evidence_of(matrix, vector):
    """Return log of how much more likely (m,) [nats] data with unit-variance columns are."""
    whole = matrix + np.eye(matrix.shape[-1])
    solved = np.linalg.solve(whole, vector[..., None])[..., 0]
    return 0.5 * np.sum(vector * solved, axis=-1) - 0.5 * np.linalg.slogdet(whole)[1]


class Search:
    """
    Intervals of a Kind against a Usual.

    recordings: slices of rows; dt [s]: usual time between rows; tried: intervals looked at.
    """

    def __init__(self, usual, kind, recordings, dt):
        self._usual, self.kind, self._recordings = usual, kind, recordings
        self._size = max(1, round(kind.cell / dt))
        self._cell = self._size * dt
        self._sums = [Sums(usual, kind, rows, self._size) for rows in recordings]
        self.tried = 0

    def best(self):
        """Return (rows of its recording, first, stop) of the likeliest interval, or None."""
        found = []
        for k, sums in enumerate(self._sums):
            count = len(sums.vector) - 1
            first, stop = self._pairs(count)
            if not len(first):
                continue
            self.tried += len(first)
            values = self._evidence(sums, first, stop)
            at = int(np.argmax(values))
            found.append((float(values[at]), k, int(first[at]), int(stop[at])))
        if not found:
            return None
        _, k, first, stop = max(found)
        return self._moved(k, first, stop)

    def moved(self, first, stop):
        """Return (rows of its recording, first, stop) with the edges where they fit best."""
        k = next(k for k, rows in enumerate(self._recordings) if first < rows.stop)
        start, count = self._recordings[k].start, len(self._sums[k].vector) - 1
        low = min((first - start) // self._size, count - self._least)
        high = min(max(round((stop - start) / self._size), low + self._least), count)
        return self._moved(k, low, high)

    def _pairs(self, count):
        """Return first and stop cells (m,) of the intervals tried in a recording."""
        first, stop = [], []
        for length in self._lengths(count):
            starts = np.arange(0, count - length + 1, max(1, length // 8))
            first.append(starts)
            stop.append(starts + length)
        if self.kind.open_ended:
            cuts = np.arange(self._least, count - self._least, 2)
            first += [cuts, np.zeros_like(cuts)]
            stop += [np.full_like(cuts, count), cuts]
        return (np.concatenate(first), np.concatenate(stop)) if first else (np.zeros(0, int),) * 2

    @property
    def _least(self):
        return max(1, round(self.kind.shortest / self._cell))

    def _lengths(self, count):
        steps = np.arange(60)
        lengths = np.unique(np.round(self._least * LADDER ** steps).astype(int))
        return lengths[lengths <= self.kind.longest * count]

    @staticmethod
    def _evidence(sums, first, stop):
        """Return evidence (m,), a few hundred intervals at a time."""
        parts = [evidence_of(*sums.between(first[k:k + 256], stop[k:k + 256]))
                 for k in range(0, len(first), 256)]
        return np.concatenate(parts)

    def _moved(self, k, first, stop):
        sums = self._sums[k]
        count = len(sums.vector) - 1
        longest = count if self.kind.open_ended else int(self.kind.longest * count)
        for _ in range(4):
            old = first, stop
            stops = np.arange(first + self._least, min(first + longest, count) + 1)
            stop = stops[np.argmax(self._evidence(sums, np.full_like(stops, first), stops))]
            starts = np.arange(max(stop - longest, 0), stop - self._least + 1)
            first = starts[np.argmax(self._evidence(sums, starts, np.full_like(starts, stop)))]
            if (first, stop) == old:
                break
        return self._to_rows(k, first, stop)

    def _to_rows(self, k, first, stop):
        rows = self._recordings[k]
        at_end = stop == len(self._sums[k].vector) - 1
        return (rows, rows.start + first * self._size,
                rows.stop if at_end else rows.start + stop * self._size)

    def excess(self, seconds):
        """
        Return chi^2 per degree of freedom of intervals as long as `seconds`.

        Its median is robust, its mean sees rare bursts: the larger. Above one where what colours
        the residual outlasts what its density says.
        """
        ratios = []
        for sums in self._sums:
            count = len(sums.vector) - 1
            length = min(max(1, round(seconds / self._cell)), count)
            first = np.arange(0, count - length + 1, max(1, length // 4))
            matrix, vector = sums.between(first, first + length)
            whole = matrix + np.eye(matrix.shape[-1])
            freedom = np.trace(np.linalg.solve(whole, matrix), axis1=1, axis2=2)
            chi = np.sum(vector * np.linalg.solve(whole, vector[..., None])[..., 0], axis=1)
            ratios.append((chi / np.maximum(freedom, 1e-9))[freedom > TOLD])
        ratios = np.concatenate(ratios)
        if not len(ratios):
            return 1.0
        return max(float(np.median(ratios)) / MEDIAN, float(ratios.mean()))


def edge_curve(usual, kind, rows, first, stop, at_first, near):
    """
    Return rows (m,) within `near` of an edge, evidence (m,) [nats] with the edge there.

    rows: slice of the recording; at_first: which edge of first..stop moves.
    """
    edge = first if at_first else stop
    middle = (first + stop) // 2
    low = max(edge - near, rows.start if at_first else middle)
    high = min(edge + near, middle if at_first else rows.stop)
    fixed = slice(high, stop) if at_first else slice(first, low)
    rest = Sums(usual, kind, fixed, fixed.stop - fixed.start)
    local = Sums(usual, kind, slice(low, high))
    moved = [part[-1] - part if at_first else part
             for part in (local.matrix, local.vector, local.cross)]
    whole = [a + b[-1] for a, b in zip(moved, (rest.matrix, rest.vector, rest.cross))]
    return np.arange(low, high + 1), evidence_of(*told(*whole))


def fit(usual, kind, first, stop):
    """Return evidence [nats], theta (k,), covariance (k, k) in units of scale for an interval."""
    matrix, vector = _of_interval(usual, kind, first, stop)
    covariance = np.linalg.inv(matrix + np.eye(len(vector)))
    return float(evidence_of(matrix, vector)), covariance @ vector, covariance


def evidence_of_any_size(usual, kind, first, stop):
    """
    Return the evidence [nats] of an interval where nobody knows how strong a Kind acts.

    A prior of one size charges many parameters more than few for being small: what weighs little
    would always be taken for a force.
    """
    matrix, vector = _of_interval(usual, kind, first, stop)
    each = evidence_of(SIZES[:, None, None] ** 2 * matrix, SIZES[:, None] * vector)
    return float(np.logaddexp.reduce(each) - np.log(len(SIZES)))


def _of_interval(usual, kind, first, stop):
    """Return information (k, k) and gradient (k,) of an interval."""
    sums = Sums(usual, kind, slice(first, stop), stop - first)
    return tuple(part[0] for part in sums.between(np.array([0]), np.array([1])))
