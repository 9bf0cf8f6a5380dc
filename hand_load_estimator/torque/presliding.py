"""
Presliding: what friction does before a joint has really moved.

A joint that reverses does not flip its friction at once: the contacts bend first, and over a
milliradian or two of travel friction goes from one Coulomb level to the other. Dahl's model
(1968) of that, dz/dq = (1 - z sign(dq))^i / s, has a closed form along a motion of one direction.
With i = 1 the level is approached for ever; with a smaller exponent, as measured curves ask for
(Dahl 1976; Al-Bender et al. 2005), it is reached, along a power 1 / (1 - i) of the travel left.
The state z in [-1, 1] is a function of the path alone, except for the value it started from.
"""

import numpy as np

from ..motion import DELAY, smeared
from .lock_step import lock_step

# Movements below this [rad] are encoder noise and do not move the contacts.
DEAD_BAND = 3e-5
# A joint slower than this [rad/s] for longer than REST_TIME [s] is at rest: its drive may creep
# and the contacts relax, so the friction it holds is not known any more. A speed above it while
# the joint stays within MOVED [rad] is noise of the sensor.
REST_SPEED = 2e-3
REST_TIME = 0.2
MOVED = 1e-4
# How far friction may be from the model, in Coulomb levels: with the path forgotten, on the way
# between two levels (the curve there differs from joint to joint), and while creeping.
UNKNOWN_START, ON_THE_WAY, CREEPING = 0.5, 0.2, 0.1
CREEP_SPEED = 0.01
# And while the motion filter shows two directions at once, about as much of either: anywhere
# between both levels would be 0.58. What may be noise of a standing joint [rad/s] is no reversal.
SMEARED, TURNS = 0.5, 0.02
# Such an error lasts about this long [s], as long as a joint is held; as a coloured error of
# that memory its density is 2 level^2 time.
STUCK_TIME = 1.0
# At rest the doubt grows with this time [s]. All of a rest then tells of the friction, pi times it
# over STUCK_TIME level^2, what no more than its bounds tell of it: a variance of half a level^2,
# where friction anywhere between its two levels has a third and the model's variances count for
# load_share of themselves.
REST_GROWTH = 0.6
LARGEST_DOUBT = 100.0


class Turning:
    """
    The way in which friction turns: what is left of the way to a level, of shapes that fit.

    power: 1 / (1 - i) of Dahl's exponent i, infinite for i = 1 and at least 1, where friction
    rises like a spring up to its level. endless: whether it is infinite everywhere.
    """

    def __init__(self, power):
        self._finite = np.isfinite(power)
        self._all, self.endless = self._finite.all(), not self._finite.any()
        self._power = np.where(self._finite, power, 1.0)
        self._root = 1.0 / self._power

    def bends(self, way):
        """Return what `after` takes of ways in travels: any number of them at once."""
        if self.endless:
            return np.exp(-way)
        along = way * self._root
        return along if self._all else np.where(self._finite, along, np.exp(-way))

    def after(self, left, bend):
        """Return what is left of `left` after the way of a bend."""
        if self.endless:
            return left * bend
        along = np.maximum(left ** self._root - bend, 0.0) ** self._power
        return along if self._all else np.where(self._finite, along, left * bend)

    def turned(self, z, moved, distance):
        """Return the state that z becomes after ways [rad] of one direction; distance: s [rad]."""
        direction, way = np.sign(moved), np.abs(moved) / distance
        left = self.after(np.maximum(1.0 - direction * z, 0.0), self.bends(way))
        return np.where(way > 0.0, direction * (1.0 - left), z)


def beyond_noise(q, anchor):
    """Return the way (k,) from an anchor to q beyond noise, and the next anchor; all in [rad]."""
    moved = q - anchor
    counts = np.abs(moved) > DEAD_BAND
    return np.where(counts, moved, 0.0), np.where(counts, q, anchor)


def ways_along(q):
    """Return the ways (N, n) [rad] beyond noise between positions q (N, n) [rad]."""
    moved, anchor = np.empty_like(q), q[0]
    for k, now in enumerate(q):
        moved[k], anchor = beyond_noise(now, anchor)
    return moved


def _kept(moved, distance):
    """Return what is left of the way to a level [-] after ways [rad] of i = 1; all after none."""
    return np.where(moved != 0.0, np.exp(-np.abs(moved) / distance), 1.0)


class PreslidingState:
    """
    Follow z and the doubt about it for joints (or columns) of any number.

    distance (k,): travel s [rad] over which friction turns; power (k,) or None: as of Turning,
    infinite without any. z (k,) in [-1, 1]; doubt (k,):
    standard deviation of z, 1 when the path is forgotten. At rest it grows on, because the same
    unknown friction for a minute tells no more than for a second.
    """

    def __init__(self, distance, power=None):
        self._distance = np.asarray(distance, dtype=float)
        finite = power is not None and np.isfinite(power).any()
        self._turning = Turning(np.asarray(power, dtype=float)) if finite else None
        self.restart()

    def restart(self):
        """Forget the path."""
        k = len(self._distance)
        self.z, self.doubt = np.zeros(k), np.ones(k)
        self._anchor, self._rests_at, self._resting = None, None, np.zeros(k)

    def update(self, q, v, dt):
        """Advance to the positions q (k,) at speeds v (k,) after dt; returns (z, doubt)."""
        if self._anchor is None:
            self._anchor = self._rests_at = q.copy()
        moved, self._anchor = beyond_noise(q, self._anchor)
        decay = _kept(moved, self._distance)
        if self._turning is None:
            direction = np.sign(moved)
            self.z = direction + (self.z - direction) * decay
        else:
            self.z = self._turning.turned(self.z, moved, self._distance)
        moves = (np.abs(v) >= REST_SPEED) & (np.abs(q - self._rests_at) > MOVED)
        self._rests_at = np.where(moves, q, self._rests_at)
        self._resting = np.where(moves, 0.0, self._resting + dt)
        self.doubt, rests = np.minimum(self.doubt, 1.0) * decay, self._resting > REST_TIME
        if rests.any():
            self.doubt = np.where(rests, doubt_after(self._resting), self.doubt)
        return self.z, self.doubt


def doubt_after(rest):
    """Return the doubt about z after a rest [s] longer than REST_TIME."""
    return np.minimum(np.hypot(1.0, (rest - REST_TIME) / REST_GROWTH), LARGEST_DOUBT)


def presliding_path(q, v, dt, distance, power=None):
    """Return z and doubt (N, n) along q, v (N, n) sampled dt (N,) apart."""
    return presliding_paths([(q, v, dt)], distance, power)[0]


def presliding_paths(motions, distance, power=None):
    """Return [(z, doubt)] of presliding_path for several motions (q, v, dt) at once."""
    def follow(numbers, rows):
        count = len(numbers)
        state = PreslidingState(np.tile(distance, count),
                                None if power is None else np.tile(power, count))
        return np.array([state.update(*row) for row in zip(*rows)])

    found = lock_step([(q, v, np.broadcast_to(dt[:, None], q.shape)) for q, v, dt in motions],
                      follow)
    return [(both[:, 0], both[:, 1]) for both in found]


def presliding_states(paths, distances, powers):
    """
    Return [z (N, K n)] along positions q (N, n) [rad] of several motions, without the doubt.

    distances (K,) [rad], powers (K,) [-] of K shapes: all n joints of the first, then of the
    second. Many at once cost little more than one.
    """
    n, shapes = paths[0].shape[1], len(distances)

    def follow(numbers, rows):
        (moved,) = rows
        distance, power = (np.tile(np.repeat(figures, n), len(numbers))
                           for figures in (distances, powers))
        out, z = np.empty_like(moved), np.zeros(moved.shape[1])
        if np.isfinite(power).any():
            turning = Turning(power)
            for k, way in enumerate(moved):
                out[k] = z = turning.turned(z, way, distance)
            return out
        for k, (direction, kept) in enumerate(zip(np.sign(moved), _kept(moved, distance))):
            out[k] = z = direction + (z - direction) * kept
        return out

    return lock_step([(np.tile(ways_along(q), shapes),) for q in paths], follow)


def stuck_variance(z, doubt, v, a, level):
    """
    Return the variance [Nm^2] of what presliding does to a model that does not know it.

    z, doubt, v [rad/s], a [rad/s^2] of any one shape; level: Coulomb level [Nm]. While a joint
    slides it is nothing; a joint that is held, creeps or turns around tells the less.
    """
    share = ((UNKNOWN_START * doubt) ** 2 + ON_THE_WAY ** 2 * (1.0 - z * z)
             + (CREEPING * np.exp(-np.abs(v) / CREEP_SPEED)) ** 2
             + SMEARED ** 2 * (smeared(v, a) & (DELAY * np.abs(a) > TURNS)))
    return share * level ** 2


def stuck_density(z, doubt, v, a, level):
    """Return the density [Nm^2 s] of that error at low frequencies."""
    return 2.0 * STUCK_TIME * stuck_variance(z, doubt, v, a, level)
