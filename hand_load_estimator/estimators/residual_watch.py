"""
Tell from the running residual that a torque model has aged: which joint, and since when.

While a joint slides, what load and model leave of its torque is averaged over short blocks. A
mean over t seconds may have the variance density / t that the model states of itself, and what
load and model are known to be uncertain by; the mean square of the ratio over minutes shows more.
Of a model that does not explain the torques at all no load may ever be known again: it then counts
as uncertain by as much as the model states, which is what the model is held to. The watch is slow
and sensitive, where MismatchWatch is quick and coarse.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from ..load import products_from_message, products_jacobian_of_message
from ..torque.sliding import BLOCK, LEAST, surely_slides
from .model_trust import MISFIT

# The load's torque is known when its variance is at most so many times the one the model states.
LOAD_KNOWN = 4.0
# Of a model that does not explain the torques: by the model's own word it has to be far better
# known, which it is after seconds of motion, or what is left of it is blamed on other joints.
WELL_KNOWN = 0.25
# Blocks are looked at so many at a time; the newest wait, for a load change to be noticed that
# explains them, and at most so many wait for the load to be known. So many before and after a
# change are not counted: its place is not exact.
REVIEW, RECENT, WAITING, ACROSS = 5, 8, 150, 2
# Most that a block counts, as a ratio: a push or a change unnoticed lasts a few blocks.
CAP = 4.0
# Memory, and the least of a joint's motion before anything is said of it [s].
MEMORY, ENOUGH = 60.0, 20.0
# A model has aged above LIMIT times its stated residual, and is well again below CALM times.
LIMIT, CALM = 1.75, 1.4
# Stamps [s] that no message has: of a joint that is well, and of one that aged before a restart,
# whose stamps counted from another second.
NEVER, EARLIER = -1.0, -2.0


@dataclass(frozen=True)
class Aged:
    """
    A joint with `ratio` times the stated residual since `since` [s], for `motion` [s] of it.

    since: EARLIER where that was before a restart; residual [Nm]: the residual itself.
    """

    joint: str
    ratio: float
    since: float
    motion: float
    residual: float


@dataclass(frozen=True)
class _Load:
    """
    What is believed to be held: products (10,), their covariance, number of load changes.

    factor: how much wider than stated the covariance is.
    """

    products: np.ndarray
    covariance: np.ndarray
    changes: int
    factor: float

    @staticmethod
    def of(method):
        """Return what a Method believes now."""
        belief = method.belief()
        jacobian = products_jacobian_of_message(belief.mean)
        # The torque holds what tare declared zero.
        return _Load(products_from_message(belief.mean) + method.tared,
                     jacobian @ belief.covariance @ jacobian.T, method.changes, method.factor)

    @staticmethod
    def as_stated(method):
        """Return the same by the regression beside a Method, as well known as its model states."""
        products, covariance = method.load_as_stated()
        return _Load(products + method.tared, covariance, method.changes, 1.0)

    def known(self, blocks, density, most):
        """Tell whether the variance of its torque in all blocks is `most` times the stated."""
        most = most * self.factor
        return not any((self.variance(block.columns) > most * block.stated(density)).any()
                       for block in blocks)

    def variance(self, columns):
        """Return the variance (..., n) [Nm^2] of the load's torque for columns (..., n, 10)."""
        return np.maximum(np.sum(columns @ self.covariance * columns, axis=-1), 0.0)


class _Block:
    """
    Means of difference and load columns over some samples, joint by joint while it slides.

    After end(): changes: load changes noticed so far; seconds (n,) of sliding; difference (n,)
    [Nm]; columns (n, 10); uncertain (n,) [Nm^2]: variance of the torque by what the model says of
    its own parameters.
    """

    def __init__(self, stamp, n):
        self.stamp, self.length = stamp, 0.0
        self._row, self._sums = np.ones((n, 12)), np.zeros((n, 12))

    def add(self, prediction, sliding, dt):
        """Add a Prediction for the joints that slide (n,) bool."""
        self._row[:, 1], self._row[:, 2:] = prediction.difference, prediction.load_columns
        self._sums += self._row * (sliding * dt)[:, None]
        self.length += dt

    def end(self, prediction, changes):
        """Take the means; the model's uncertainty hardly changes within a block."""
        self.changes = changes
        self.seconds = self._sums[:, 0]
        means = self._sums / np.maximum(self.seconds, 1e-9)[:, None]
        self.difference, self.columns = means[:, 1], means[:, 2:]
        self.uncertain = np.sum(prediction.model_columns ** 2, axis=1)

    def stated(self, density):
        """Return the variance (n,) [Nm^2] that the model states of the means."""
        return density / np.maximum(self.seconds, LEAST)

    def squares(self, density, load):
        """
        Return the squared ratio (n,) of what a load leaves to what may be left, up to a cap.

        Beside it what is left, squared (n,) [Nm^2], up to the same cap.
        """
        left = self.difference - self.columns @ load.products
        expected = self.stated(density) + self.uncertain + load.variance(self.columns)
        ratio = np.minimum(left ** 2 / expected, CAP ** 2)
        return ratio, ratio * expected


class ResidualWatch:
    """
    Follow each joint's residual against what the torque model states of it.

    joints: names; density (n,) [Nm^2 s]: stated of the residual at low frequencies. ratio (n,):
    residual over the stated one, 1 or less for a model that keeps its word, at most CAP; residual
    (n,) [Nm]: that residual, to be held against Residuals.sliding; seconds (n,): motion it was
    judged by, all in all.
    """

    def __init__(self, joints, density):
        n = len(joints)
        self._joints, self._density = joints, density
        self._square, self._torque, self.seconds = np.zeros(n), np.zeros(n), np.zeros(n)
        self._since, self._before = np.full(n, np.nan), np.zeros(n)
        self._aged = np.zeros(n, dtype=bool)
        self.forget_load()

    def forget_load(self):
        """Trust no load until it is known again, as after a reset."""
        self._load, self._waiting = None, deque(maxlen=WAITING)
        self._block, self._fresh = None, 0

    def state(self):
        """Return {name: array (n,)}: what restore() of another watch goes on from."""
        # Copies: a file is written from them while the watch goes on.
        return {'square': self._square.copy(), 'torque': self._torque.copy(),
                'seconds': self.seconds.copy(),
                'since': np.where(np.isnan(self._since), NEVER, self._since),
                'before': self._before.copy(), 'aged': self._aged.astype(float)}

    def restore(self, state):
        """Go on from finite arrays as of state(); what the hand holds is to be found anew."""
        self._square, self._torque, self.seconds, since, self._before, aged = (
            np.array(state[name], dtype=float) for name in self.state())
        self._since = np.where(since == NEVER, np.nan, EARLIER)
        self._aged = aged > 0.5
        self.forget_load()

    @property
    def ratio(self):
        """Residual over the stated one (n,)."""
        return np.sqrt(self._square)

    @property
    def residual(self):
        """What load and model leave (n,) [Nm]."""
        return np.sqrt(self._torque)

    @property
    def enough(self):
        """Whether each joint (n,) has moved enough to be judged."""
        return self.seconds >= ENOUGH

    @property
    def aged(self):
        """The Aged joints, worst first."""
        found = [Aged(self._joints[j], float(self.ratio[j]), float(self._since[j]),
                      float(self.seconds[j] - self._before[j]), float(self.residual[j]))
                 for j in np.flatnonzero(self._aged)]
        return tuple(sorted(found, key=lambda aged: -aged.ratio))

    def update(self, sample, prediction, method):
        """Take a MotionSample, its Prediction and the Method that has seen them."""
        sliding = surely_slides(sample.v, prediction.z, prediction.doubt)
        if not sliding.any():
            return
        if self._block is None:
            self._block = _Block(sample.stamp, len(self._joints))
        self._block.add(prediction, sliding, sample.dt)
        if self._block.length >= BLOCK:
            self._block.end(prediction, method.changes)
            self._waiting.append(self._block)
            self._block, self._fresh = None, self._fresh + 1
        if self._fresh >= REVIEW:
            self._fresh = 0
            self._review(_Load.of(method), method)

    def _review(self, load, method):
        """Count the blocks that are settled, with the load as a Method believes it now."""
        newest = list(self._waiting)[-REVIEW:]
        known = load.known(newest, self._density, LOAD_KNOWN)
        if not known and method.factor > MISFIT:
            load = _Load.as_stated(method)
            known = load.known(newest, self._density, WELL_KNOWN)
        if not known:
            return
        before, self._load = self._load, load
        if before is not None and load.changes != before.changes:
            self._settle_change(before, load)
        while len(self._waiting) > RECENT:
            self._count(self._waiting.popleft(), load)

    def _settle_change(self, old, new):
        """Count the blocks that belong to the old load; keep those that belong to the new."""
        blocks = list(self._waiting)
        seen = sum(block.changes == old.changes for block in blocks)
        if new.changes > old.changes + 1:
            # Between the two there were others, never known, the first of them unnoticed a while.
            last, first = seen - RECENT, sum(block.changes < new.changes for block in blocks)
        else:
            # A change is noticed late: it was where the two loads together explain most.
            explained = [np.array([block.squares(self._density, load)[0].sum()
                                   for block in blocks]) for load in (old, new)]
            costs = np.concatenate([[0.0], np.cumsum(explained[0] - explained[1])])
            middle = int(np.argmin(costs[:seen + 1]))
            last, first = middle - ACROSS, middle + ACROSS
        for block in blocks[:max(last, 0)]:
            self._count(block, old)
        self._waiting = deque(blocks[first:], maxlen=WAITING)

    def _count(self, block, load):
        seconds = np.where(block.seconds >= LEAST, block.seconds, 0.0)
        before = self.seconds.copy()
        self.seconds += seconds
        # A plain mean until there is as much as the memory holds.
        share = seconds / np.maximum(np.minimum(self.seconds, MEMORY), 1e-9)
        square, torque = block.squares(self._density, load)
        self._square += share * (square - self._square)
        self._torque += share * (torque - self._torque)
        self._note(block.stamp, before)

    def _note(self, stamp, before):
        """Note since when, and before what motion, a joint is beyond what it should."""
        beyond = self._square > CALM ** 2
        rising = beyond & np.isnan(self._since)
        self._since[rising], self._before[rising] = stamp, before[rising]
        self._since[~beyond] = np.nan
        self._aged = beyond & (self._aged | self._ready() & (self._square > LIMIT ** 2))

    def _ready(self):
        """
        Return the joints (n,) that may be told of.

        One wrong joint spoils the load and so the others a little: the worst is waited for.
        """
        worst = int(np.argmax(self._square))
        return self.enough & (self.enough[worst] | (self.seconds >= 2.0 * ENOUGH))
