"""How far the friction that a joint began with is unknown, as the motion filter shows it."""

import numpy as np

from .presliding import Rests
from .shown_filter import filtered, filtered_along

# A doubt below this [-] is none, and need not be followed.
NOTHING = 1e-12


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
        path = np.concatenate([self._left[None], _within(
            self._left, _decay(moved, self._distance), doubt, rests)])
        self._left = path[-1]
        self._stages = filtered(self._stages, path, dt)
        return self._stages[2]


def _decay(moved, distance):
    """Return what is left (..., STEPS, k) [-] of a start after ways (..., STEPS, k) [rad]."""
    return np.exp(-np.cumsum(np.abs(moved), axis=-2) / distance)


def _within(left, decay, doubt, rests):
    """Return the doubt (STEPS, k) within a sample that began with `left` (k,)."""
    return np.where(rests, doubt, np.minimum(left, 1.0) * decay)


def start_doubt_along(moved, q, v, dt, distance):
    """Return the doubt (N, n) of StartDoubt along ways moved (N, STEPS, n); dt (N,)."""
    rests, left, out = Rests(q[0]), np.ones(moved.shape[2]), []
    for *state, decay in zip(q, v, dt, _decay(moved, distance)):
        out.append(np.concatenate([left[None], _within(left, decay, *rests.update(*state))]))
        left = out[-1][-1]
    stages = np.ones((1, 3, moved.shape[2]))
    return filtered_along(stages, np.array(out)[:, None], dt[:, None])[:, 0, 2]
