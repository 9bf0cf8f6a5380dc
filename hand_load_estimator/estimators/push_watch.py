"""
Tell a push on the hand from another load.

Both come suddenly, and what either does to the joints at one moment the other may do, too. But a
load's products stay as the hand turns and speeds up, while a push keeps its force and moment, in
the base's axes, for a while. So all samples of a while are compared with both: the log Bayes
factor of a constant force and moment, and that of other products (change.py), each against the
belief from before. Where the hand hardly moves they are alike, and nothing is told.
"""

import numpy as np

from .change import factor_of, log_bayes_factor
from .information import Information
from .positive_solve import positive_solve
from .regression import SETTLING

# Standard deviation of a push's force, in weights of the rated load.
FORCE = 0.5
# Of the evidence of any change, a push has to be ahead by so much: a load of which each joint
# misreads a tenth of the torque, one too much and the next too little, leaves that.
SHARE = 0.01
# And of what another load leaves of it, a push has to explain so much: what comes by and by, as
# a load that is handed over, neither explains.
OF_THE_REST = 0.5
# While a push lasts it is looked at anew every so many seconds: hands do not push evenly.
ANEW = 0.25


class PushWatch:
    """
    Compare a push with another load, sample by sample, from begin() to end().

    robot: Robot; prior: LoadPrior; change (10, 10): covariance of what the products may change
    by with the load; nuisances: number r of model columns. told: whether a push explains the
    torques, and no load does as well.
    """

    def __init__(self, robot, prior, change, nuisances):
        self._robot, self._change, self._nuisances = robot, change, nuisances
        force = FORCE * robot.rated_load.mass * np.linalg.norm(robot.model.gravity.linear)
        lever = np.linalg.norm(prior.mean[1:4]) + prior.std[1:4].max()
        self._wrench = np.diag(np.repeat([force, force * lever], 3)) ** 2
        self.end()

    @property
    def begun(self):
        """Whether it compares."""
        return self._older is not None

    def begin(self, older, needed, longest):
        """
        Compare with the Older belief from here on, for `longest` [s] unless a push is told.

        needed: evidence [nats] that a push has to be ahead of another load, or that of a push.
        """
        self._older, self._needed, self._left, self.told = older, needed, longest, False
        self._anew()
        self._length = -SETTLING

    def end(self):
        """Compare no longer."""
        self._older, self.told = None, False

    def take(self, sample, columns, difference, density):
        """
        Take a MotionSample, its joined_columns, difference (n,) [Nm] and density (n,) [Nm^2 s].

        Return whether a push is told.
        """
        if not self.begun:
            return False
        self._length, self._left = self._length + sample.dt, self._left - sample.dt
        if self._length <= 0.0:
            return False
        weights = sample.dt / density
        wrench = self._robot.hand_wrench_columns(sample.q)
        self._load.add_rows(columns, difference, weights)
        self._push += (wrench.T * weights).dot(np.concatenate(
            [difference[:, None], columns, wrench], axis=1))
        push, load, most = self._evidence()
        if push - load > max(self._needed, SHARE * push, OF_THE_REST * (most - load)):
            self.told = True
        elif load - push > self._needed:
            self.told = False
        if self.told and self._length >= ANEW:
            self._anew()
        elif not self.told and (self._left <= 0.0 or load - push > self._needed):
            self.end()
        return self.told

    def _anew(self):
        self._load, self._length = Information(0, self._nuisances), 0.0
        self._push = np.zeros((6, 1 + 10 + self._nuisances + 6))

    def _evidence(self):
        """Return the log Bayes factors of a push and of another load, and what neither exceeds."""
        older, load = self._older, self._load
        vector, shared, own = np.split(self._push, [1, 1 + len(older.mean)], axis=1)
        score = load.vector - load.matrix @ older.mean
        solved = positive_solve(older.precision + load.matrix,
                                np.column_stack([score, shared.T]))
        b = vector[:, 0] - shared @ older.mean - shared @ solved[:, 0]
        return (factor_of(b, own - shared @ solved[:, 1:], self._wrench),
                log_bayes_factor(load, older.mean, older.precision, self._change),
                0.5 * (load.left_by(older.mean) - score @ solved[:, 0]))
