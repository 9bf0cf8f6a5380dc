"""
Presliding: what friction does before a joint has really moved.

A joint that reverses does not flip its friction at once: the contacts bend first, and over a
milliradian or two of travel friction goes from one Coulomb level to the other. Dahl's model
(1968) of that, dz/dq = (1 - z sign(dq)) / s, yields all the way. Elastoplastic contacts (Dupont et
al. 2002) are a spring until friction is within a share p of the level, and yield from there on:
dz/dq = k min(1 - z sign(dq), p) / s. Both have a closed form along a motion of one direction. k is
such that a reversal takes the same work off friction whatever p is, 2 s times the level, so that a
travel means the same for all of them. The state z in [-1, 1] is a function of the path alone,
except for the value it started from. Up to a level that falls (contact_level.py) it may be beyond
for a moment, after a reversal.
"""

import numpy as np

from ..effects.own_travel import BOTH

# A joint slower than this [rad/s] for longer than REST_TIME [s] is at rest: its drive may creep
# and the contacts relax, so the friction it holds is not known any more. A speed above it while
# the joint stays within MOVED [rad] is noise of the sensor.
REST_SPEED = 2e-3
REST_TIME = 0.2
MOVED = 1e-4
# How far friction may be from the model, in Coulomb levels: with the path forgotten, on the way
# between two levels (the curve there differs from joint to joint), and while creeping.
UNKNOWN_START, ON_THE_WAY, CREEPING = 0.5, 0.1, 0.1
CREEP_SPEED = 0.01
# Such an error lasts about this long [s], as long as a joint is held; as a coloured error of
# that memory its density is 2 level^2 time.
STUCK_TIME = 1.0
# At rest the doubt grows with this time [s]. All of a rest then tells of the friction, pi times it
# over STUCK_TIME level^2, what no more than its bounds tell of it: a variance of half a level^2,
# where friction anywhere between its two levels has a third and the model's variances count for
# load_share of themselves.
REST_GROWTH = 0.6
# More levels than ever lie on a way.
ENDLESS = 1e9


class Turning:
    """
    The way in which friction turns: what is left of the way to a level.

    plastic: p, the last of that way, in levels, over which contacts yield; from BOTH on they do
    all the way (Dahl). yields: whether all of them do.
    """

    def __init__(self, plastic):
        yields = np.asarray(plastic) >= BOTH
        self.yields, own = bool(np.all(yields)), np.minimum(plastic, BOTH)
        self._pace = (BOTH ** 2 + own ** 2) / (2.0 * BOTH * own)
        # Where a level has fallen more than BOTH may be left of the way: of that, too, all yields.
        self._plastic = np.where(yields, ENDLESS, own)
        self._per_plastic = 1.0 / self._plastic

    def bends(self, way):
        """Return what `after` takes of ways in travels: any number of them at once."""
        return self._pace * way

    def after(self, left, bend):
        """Return what is left of `left` after the way of a bend."""
        if self.yields:
            return left * np.exp(-bend)
        # An exponential is nowhere below its tangent: the larger of both is the one that holds.
        beyond = np.minimum(np.maximum(self._per_plastic * left, 1.0) - (1.0 + bend), 0.0)
        return np.maximum(left - self._plastic * bend,
                          np.minimum(left, self._plastic) * np.exp(beyond))

    def turned(self, z, moved, distance):
        """Return the state that z becomes after ways [rad] of one direction; distance: s [rad]."""
        direction, way = np.sign(moved), np.abs(moved) / distance
        left = self.after(np.maximum(1.0 - direction * z, 0.0), self.bends(way))
        return np.where(way > 0.0, direction * (1.0 - left), z)


class Rests:
    """
    Tell for how long joints (or columns) of any number have been at rest.

    q (k,) [rad]: where they begin.
    """

    def __init__(self, q):
        self._at, self._resting = q, np.zeros(len(q))

    def update(self, q, v, dt):
        """Return the doubt (k,) about z after a rest, and which (k,) rest; q, v (k,) after dt."""
        moves = (np.abs(v) >= REST_SPEED) & (np.abs(q - self._at) > MOVED)
        self._at = np.where(moves, q, self._at)
        self._resting = np.where(moves, 0.0, self._resting + dt)
        return doubt_after(self._resting), self._resting > REST_TIME


class PreslidingState:
    """
    Follow z and the doubt about it along a motion that is planned, not measured.

    distance (k,): travel s [rad] over which friction turns; plastic (k,): of Turning. z (k,) in
    [-1, 1]; doubt (k,): standard deviation of z, 1 when the path is forgotten. At rest it grows
    on, because the same unknown friction for a minute tells no more than for a second.
    """

    def __init__(self, distance, plastic):
        self._distance, self._turning = np.asarray(distance, dtype=float), Turning(plastic)
        self._before = self._rests = None
        self.z, self.doubt = np.zeros(len(self._distance)), np.ones(len(self._distance))

    def update(self, q, v, dt):
        """Advance to the positions q (k,) at speeds v (k,) after dt; returns (z, doubt)."""
        if self._before is None:
            self._before, self._rests = q, Rests(q)
        moved, self._before = q - self._before, q
        self.z = self._turning.turned(self.z, moved, self._distance)
        doubt, rests = self._rests.update(q, v, dt)
        self.doubt = np.where(rests, doubt, np.minimum(self.doubt, 1.0)
                              * np.exp(-np.abs(moved) / self._distance))
        return self.z, self.doubt


def doubt_after(rest):
    """Return the doubt about z after a rest [s]: of one longer than REST_TIME."""
    return np.hypot(1.0, (rest - REST_TIME) / REST_GROWTH)


def stuck_variance(z, doubt, v, level):
    """
    Return the variance [Nm^2] of what presliding does to a model that does not know it.

    z, doubt, v [rad/s] of any one shape; level: Coulomb level [Nm]. While a joint slides it is
    nothing; a joint that is held, creeps or turns around tells the less.
    """
    # Rounding may leave a filtered z just above one, which is no variance below zero.
    share = ((UNKNOWN_START * doubt) ** 2 + ON_THE_WAY ** 2 * np.maximum(1.0 - z * z, 0.0)
             + (CREEPING * np.exp(-np.abs(v) / CREEP_SPEED)) ** 2)
    return share * level ** 2


def stuck_density(z, doubt, v, level):
    """Return the density [Nm^2 s] of that error at low frequencies."""
    return 2.0 * STUCK_TIME * stuck_variance(z, doubt, v, level)
