"""
Motion that recordings repeat: what is held out must not have its twin among what is fitted.

Two moments are twins where all joints have the same positions and velocities, whatever the time
between them: in another run of the same programme, or a cycle later.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

# Positions and velocities are the same within these shares of what recordings cover of them, and
# of no less than so much [rad], [rad/s].
SAME_POSITION, SAME_VELOCITY = 0.04, 0.1
LEAST_RANGE, LEAST_SPEED = 0.1, 0.1
# Rows are compared this far apart [s]; a path that was left for less than AWAY [s] never was, and
# one shared for less than SHARED [s] is a crossing.
STEP, AWAY, SHARED = 0.05, 0.5, 1.0
AT_ONCE = 1000  # rows
# An arm none of whose joints is faster than this share of the greatest velocity stands.
STANDS = 0.1


@dataclass(frozen=True)
class Shown:
    """
    When motion was shown first.

    first (N,): row in which the motion of each row was shown first, its own if never before;
    while the arm stands, as for the last row in which it moved. moving (N,): it does not stand.
    """

    first: np.ndarray
    moving: np.ndarray

    @property
    def fresh(self):
        """Rows (N,) bool whose motion was never shown before."""
        return self.first == np.arange(len(self.first))


def first_shown(q, v, dt, owner):
    """Return the Shown of positions, velocities (N, n) [rad], [rad/s]; dt, owner (N,)."""
    fast = np.abs(v).max(axis=1)
    moving, time = fast > STANDS * fast.max(), np.cumsum(dt)
    if not moving.any():
        return Shown(np.arange(len(q)), moving)
    chosen = _spaced(time, moving, owner)
    # Recordings are far apart in time, as no two passes of one are.
    apart = time[chosen] + 2.0 * AWAY * owner[chosen]
    state = _scaled(q[chosen], v[chosen])
    return Shown(_of_all_rows(chosen, _followed(_lasting(_twins(state, apart), apart)), owner),
                 moving)


def share_shown(evidence, test):
    """Return the share of the motion of test Evidence that other Evidence has shown before."""
    shown, dt, owner = _shown_by((*evidence, *test))
    moved = dt * (shown.moving & (owner >= len(evidence)))
    return _share(moved, owner[shown.first] < len(evidence))


def share_repeated(evidence):
    """Return the share of the motion of Evidence that it has shown before itself."""
    shown, dt, _ = _shown_by(evidence)
    return _share(dt * shown.moving, ~shown.fresh)


def _shown_by(evidence):
    """Return the Shown of all Evidence one after another, dt (N,) [s], which of them (N,)."""
    motions = [e.motion for e in evidence]
    owner = np.concatenate([np.full(len(m.dt), k) for k, m in enumerate(motions)])
    q, v, dt = (np.concatenate([getattr(m, name) for m in motions]) for name in ('q', 'v', 'dt'))
    return first_shown(q, v, dt, owner), dt, owner


def _share(moved, rows):
    return float(moved @ rows) / max(float(moved.sum()), 1e-9)


def _spaced(time, moving, owner):
    """Return the rows to compare: while the arm moves, STEP apart."""
    rows = np.flatnonzero(moving)
    tick, part = time[rows] // STEP, owner[rows]
    return rows[(np.diff(tick, prepend=-1.0) != 0) | (np.diff(part, prepend=-1) != 0)]


def _scaled(q, v):
    """Return (M, 2 n) in units of what passes for the same."""
    span, speed = np.ptp(q, axis=0), np.abs(v).max(axis=0)
    return np.hstack([q / (SAME_POSITION * np.maximum(span, LEAST_RANGE)),
                      v / (SAME_VELOCITY * np.maximum(speed, LEAST_SPEED))])


def _twins(state, time):
    """Return (M,): the nearest earlier row on another pass, -1 where there is none."""
    found = np.full(len(state), -1)
    for start in range(0, len(state), AT_ONCE):
        rows = np.arange(start, min(start + AT_ONCE, len(state)))
        # Of what was shown once, the first time stands for all: hours of cycles stay one.
        known = np.concatenate([np.flatnonzero(found[:start] < 0), rows])
        balls = cKDTree(state[known]).query_ball_point(state[rows], 1.0, p=np.inf,
                                                       return_sorted=True)
        for row, near in zip(rows, balls):
            near = known[near]
            near = near[near <= row]
            left = np.flatnonzero(np.diff(time[near]) > AWAY)
            if len(left):
                earlier = near[:left[-1] + 1]
                found[row] = earlier[np.abs(state[earlier] - state[row]).max(axis=1).argmin()]
    return found


def _lasting(found, time):
    """Return the twins (M,) of stretches that last, their short gaps filled."""
    out, rows = np.full(len(found), -1), np.flatnonzero(found >= 0)
    for stretch in np.split(rows, np.flatnonzero(np.diff(time[rows]) > AWAY) + 1):
        if len(stretch) and time[stretch[-1]] - time[stretch[0]] >= SHARED:
            whole = np.arange(stretch[0], stretch[-1] + 1)
            out[whole] = found[stretch[np.searchsorted(stretch, whole, side='right') - 1]]
    return out


def _followed(found):
    """Return (M,): the first of all rows that are twins of one another, by way of any others."""
    first = np.arange(len(found))
    for row in np.flatnonzero(found >= 0):
        first[row] = first[found[row]]
    return first


def _of_all_rows(chosen, first, owner):
    """Return (N,) rows shown first, from those of the chosen rows."""
    out = np.arange(len(owner))
    for k in np.unique(owner[chosen]):
        rows, own = np.flatnonzero(owner == k), np.flatnonzero(owner[chosen] == k)
        last = own[np.maximum(np.searchsorted(chosen[own], rows, side='right') - 1, 0)]
        again = first[last] != last
        out[rows[again]] = chosen[first[last[again]]]
    return out
