"""
Play: what a gap between the teeth of a gear does to the torque of its drive.

Two bodies and a dead zone with rigid teeth (Nordin and Gutman 2002, section 2). While the teeth
touch, the drive carries the link. When the torque through the gear changes sign they part: the
drive carries nothing, and the link, left to itself, falls behind or runs ahead of it,
p'' = torque / inertia for the angle p by which the drive leads. On the other side of the gap the
teeth meet and the drive takes the link's momentum at once. So a crossing spares the drive a torque
and returns all of its integral with the impact.
"""

from functools import lru_cache
import math

import numpy as np

from .motion import BANDWIDTH, filter_step

# Steps of a crossing within a sample: two milliseconds at the motion filter's rate.
STEPS = 10
# The motion filter delays by this [s].
FILTER_DELAY = 3.0 / BANDWIDTH
# Times between samples are rounded to this [s], so that jitter makes no end of filters.
ROUNDED = 1e-4


@lru_cache(maxsize=4096)
def _filter(count):
    """Return (3, 3) and (3, STEPS): the motion filter over `count` ROUNDED, inputs held a step."""
    matrix, before, now = filter_step(max(count, 1) * ROUNDED / STEPS)
    powers = [np.linalg.matrix_power(matrix, k) for k in range(STEPS, -1, -1)]
    return powers[0], np.stack([p @ (before + now) for p in powers[1:]], axis=1)


class PlayState:
    """
    Follow the gap of one joint, and what its drive feels of it as the motion filter shows it.

    Starts with the teeth together on the side that the torque pushes to.
    """

    def __init__(self):
        self._torque = self._ahead = None  # [Nm] shown by the filter, and without its delay
        self._place = self._speed = 0.0
        self._apart = False
        self._shown = np.zeros(3)

    def update(self, torque, inertia, travel, lag, dt):
        """
        Return the torque [Nm] that play adds to the drive's, after dt [s].

        torque [Nm] that the gear has to carry, inertia [kg m^2] of the link about its joint, both
        of the filtered motion; travel [rad] of the gap; lag [s] of the torque between the teeth
        behind it, by which they part late.
        """
        if self._torque is None:
            self._torque = self._ahead = torque
            self._place = math.copysign(0.5 * travel, torque)
        # What the filter shows is late; the teeth part when the torque itself changes sign.
        ahead = torque + (FILTER_DELAY - lag) * (torque - self._torque) / dt
        before, self._torque, self._ahead = self._ahead, torque, ahead
        if self._apart or before * self._place < 0.0 or ahead * self._place < 0.0:
            slope, step = (ahead - before) / STEPS, dt / STEPS
            felt = [self._cross(before + (k + 0.5) * slope, inertia, 0.5 * travel, step)
                    for k in range(STEPS)]
            matrix, gains = _filter(round(dt / ROUNDED))
            self._shown = matrix @ self._shown + gains @ felt
        elif self._shown.any():
            self._shown = _filter(round(dt / ROUNDED))[0] @ self._shown
        return float(self._shown[2])

    def _cross(self, torque, inertia, half, step):
        """Return the mean torque [Nm] over a step [s] under a constant torque of the link."""
        if not self._apart and torque * self._place >= 0.0:
            return 0.0
        if inertia <= 0.0:
            # A robot file may state no inertia: a link without any is across at once.
            self._place, self._apart = math.copysign(half, torque), False
            return 0.0
        speed = self._speed + step * torque / inertia
        place = self._place + 0.5 * step * (self._speed + speed)
        self._apart = abs(place) < half
        if self._apart:
            self._place, self._speed = place, speed
            return -torque
        self._place, self._speed = math.copysign(half, place), 0.0
        return inertia * speed / step - torque


def play_along(torque, inertia, dt, states=None):
    """
    Return play(joints, travels, lags): what gaps do along torque, inertia (N, n), dt (N,) [s].

    Torques [Nm] as of PlayState.update: for one joint (N,), for arrays of m joints (N, m).
    states: PlayState (n) to carry on; new ones without.
    """
    def of(j, travel, lag):
        state = PlayState() if states is None else states[j]
        rows = zip(torque[:, j].tolist(), inertia[:, j].tolist(), dt.tolist())
        return np.array([state.update(tau, moved, travel, lag, step) for tau, moved, step in rows])

    def play(joints, travels, lags):
        if np.ndim(joints) == 0:
            return of(joints, travels, lags)
        return np.stack([of(*one) for one in zip(joints, travels, lags)], axis=1)
    return play
