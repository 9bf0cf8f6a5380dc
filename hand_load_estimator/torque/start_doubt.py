"""How far the friction that a joint began with is unknown, as the motion filter shows it."""

import numpy as np

from .presliding import Rests
from .shown_filter import filtered, filtered_along

# A doubt below this [-] is none, and need not be followed.
NOTHING = 1e-12
# How large a doubt the motion filter still shows when a rest ends: of hours it would show for the
# first tenth of a second of motion, in which nothing were told then.
LARGEST_SHOWN = 100.0


class StartDoubt:
    """
    Follow the standard deviation of friction of size one for joints of any number.

    distance (k,) [rad]: travel over which it turns. 1 when the path is forgotten; at rest it grows
    on (presliding.Rests).
    """

    def __init__(self, distance):
        self._distance = np.asarray(distance, dtype=float)
        self._none = np.zeros(len(self._distance))
        self.restart()

    def restart(self):
        """Forget the path."""
        self._rests, self._left = None, np.ones(len(self._distance))
        self._stages = np.ones((3, len(self._distance)))

    def update(self, moved, q, v, dt):
        """Return the doubt (k,) after ways moved (STEPS, k) [rad], at q [rad], v [rad/s] (k,)."""
        if self._rests is None:
            self._rests = Rests(q)
        doubt, rests = self._rests.update(q, v, dt)
        if self._stages.max() < NOTHING and self._left.max() < NOTHING and not rests.any():
            return self._none
        decay = np.exp(-np.cumsum(np.abs(moved), axis=0) / self._distance)
        within = np.where(rests, np.minimum(doubt, LARGEST_SHOWN),
                          np.minimum(self._left, 1.0) * decay)
        path = np.concatenate([self._left[None], within])
        self._left = path[-1]
        self._stages = filtered(self._stages, path, dt)
        return np.where(rests & (doubt > LARGEST_SHOWN), doubt, self._stages[2])


def rests_along(q, v, dt):
    """Return Rests' doubt (N, n), and which (N, n) rest, along a motion q, v (N, n), dt (N,)."""
    rests = Rests(q[0])
    return tuple(map(np.array, zip(*(rests.update(*row) for row in zip(q, v, dt)))))


def start_doubt_along(moved, rested, dt, distance):
    """
    Return the doubt (N, n) of StartDoubt along a motion.

    moved (N, STEPS, n): ways [rad]; rested: rests_along; dt (N,) [s]; distance (n,) [rad].
    """
    (doubt, rests), n = rested, moved.shape[2]
    way = np.cumsum(np.abs(moved), axis=1)
    begun = np.vstack([np.zeros(n), np.cumsum(way[:, -1], axis=0)])
    # From where a joint last rested on all of it is in doubt.
    last = np.maximum.accumulate(np.where(rests, np.arange(1, len(dt) + 1)[:, None], 0), axis=0)
    turned = way + (begun[:-1] - np.take_along_axis(begun, last, axis=0))[:, None]
    within = np.where(rests[:, None], np.minimum(doubt, LARGEST_SHOWN)[:, None],
                      np.exp(-np.maximum(turned, 0.0) / distance))
    path = np.concatenate([np.vstack([np.ones(n), within[:-1, -1]])[:, None], within], axis=1)
    shown = filtered_along(np.ones((1, 3, n)), path[:, None], dt[:, None])[:, 0, 2]
    return np.where(rests & (doubt > LARGEST_SHOWN), doubt, shown)
