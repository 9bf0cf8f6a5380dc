"""
Compare hypotheses on data not used to fit them, from sums over blocks of the recordings.

A hypothesis adds columns C theta to the torque of some joints. Sums of products over blocks of a
few seconds are all that is needed: fitting without a fold and scoring the fold are both quadratic
forms in them. The nuisances D delta (what the model's own uncertainty may do) are refitted beside
theta each time, with unit variance.
"""

from copy import copy
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Score:
    """
    How a hypothesis does on held-out blocks.

    gain, std [nats]; by_block (G,) [nats], blocks of one group together; theta, covariance (k,),
    (k, k): fit on all blocks, in units of the prior; by_joint {joint: nats}.
    """

    gain: float
    std: float
    by_block: np.ndarray
    theta: np.ndarray
    covariance: np.ndarray
    by_joint: dict


class Blocks:
    """
    Residual, weights and nuisances of n joints, cut into blocks.

    residual, weights (N, n); nuisances: list of (N, R_j); starts (B,): first row of each block;
    folds (B,): fold of each block; groups (B,): from 0, blocks that are one observation, or None
    where each is one.
    """

    def __init__(self, residual, weights, nuisances, starts, folds, groups=None):
        self.residual, self.weights, self.nuisances = residual, weights, list(nuisances)
        self.starts, self.folds = starts, folds
        self._groups = np.arange(len(starts)) if groups is None else groups
        self._ends = np.append(starts[1:], len(residual))
        numbers, self._fold_of_blocks = np.unique(folds, return_inverse=True)
        self._trains = np.ones((len(numbers) + 1, len(starts)))
        self._trains[self._fold_of_blocks, np.arange(len(starts))] = 0.0
        self._joints = [self._joint(j) for j in range(residual.shape[1])]

    def add(self, columns):
        """Make columns {joint: (N, k)} (in units of their prior) nuisances from now on."""
        for j, extra in columns.items():
            self.nuisances[j] = np.hstack([self.nuisances[j], extra])
            self._joints[j] = self._joint(j)

    def beside(self, columns):
        """Return Blocks with columns {joint: (N, k)} among the nuisances; these stay the same."""
        other = copy(self)
        other.nuisances, other._joints = list(self.nuisances), list(self._joints)
        other.add(columns)
        return other

    def fold_of_rows(self):
        """Return the fold (N,) of each row."""
        return np.repeat(self.folds, np.diff(self._ends, prepend=0))

    def only(self, j, rows):
        """Return Blocks in which nothing but some rows (N,) bool of joint j counts there."""
        other = copy(self)
        other.weights, other._joints = self.weights.copy(), list(self._joints)
        other.weights[~rows, j] = 0.0
        other._joints[j] = other._joint(j)
        return other

    def left_over(self, j, beside=0.0):
        """
        Return the residual (N,) of joint j after its nuisances, fitted to all blocks.

        beside (N,) [Nm]: a torque that they are not fitted to; it stays in what is returned.
        """
        own, d = self._joints[j], self.nuisances[j]
        told = d.T @ (self.weights[:, j] * (self.residual[:, j] - beside))
        delta = np.linalg.solve(self._trained(own)[-1], told)
        return self.residual[:, j] - d @ delta

    def misfit(self, j):
        """Return the nats (G,) that held-out blocks of joint j are off by beside the nuisances."""
        return np.bincount(self._groups, 0.5 * self._left_by_nuisances(self._joints[j]))

    def evaluate(self, columns):
        """Return the Score of columns {joint: (N, k)}, in units of their prior's std."""
        sums = {j: self._cross(j, c) for j, c in columns.items()}
        theta, covariance, deltas = self._fits(sums)
        held_out, by_joint = theta[self._fold_of_blocks], {}
        for j, crossed in sums.items():
            own, delta = self._joints[j], deltas[j][self._fold_of_blocks]
            by_joint[j] = 0.5 * (self._left_by_nuisances(own)
                                 - _squares(own, crossed, delta, held_out))
        gains = np.bincount(self._groups, sum(by_joint.values()))
        std = np.sqrt(len(gains)) * gains.std()
        return Score(gains.sum(), std, gains, theta[-1], covariance[-1],
                     {j: gain.sum() for j, gain in by_joint.items()})

    def _joint(self, j):
        d, w = self.nuisances[j], self.weights[:, j]
        r = self.residual[:, j]
        dd, dr, rr = [], [], []
        for a, b in zip(self.starts, self._ends):
            wd = d[a:b] * w[a:b, None]
            dd.append(wd.T @ d[a:b])
            dr.append(wd.T @ r[a:b])
            rr.append(float((w[a:b] * r[a:b]) @ r[a:b]))
        return _Sums(np.array(dd), np.array(dr), np.array(rr))

    def _cross(self, j, columns):
        weighted = columns * self.weights[:, j, None]
        k, r = columns.shape[1], self.nuisances[j].shape[1]
        right = np.column_stack([columns, self.nuisances[j], self.residual[:, j]])
        sums = np.array([weighted[a:b].T @ right[a:b] for a, b in zip(self.starts, self._ends)])
        return sums[:, :, :k], sums[:, :, k:k + r], sums[:, :, k + r]

    def _left_by_nuisances(self, own):
        """Return the weighted squares (B,) of _Sums after nuisances fitted without each fold."""
        if own.left is None:
            delta = np.linalg.solve(self._trained(own), self._over_trains(own.dr)[..., None])
            own.left = own.squares(delta[self._fold_of_blocks, :, 0])
        return own.left

    def _trained(self, own):
        """Return the normal matrices (F + 1, R, R) of _Sums' nuisances, as of _over_trains."""
        if own.trained is None:
            own.trained = self._over_trains(own.dd) + np.eye(own.dd.shape[1])
        return own.trained

    def _over_trains(self, sums):
        """Return sums (B, ...) over all blocks but those of a fold, and over all: (F + 1, ...)."""
        return np.tensordot(self._trains, sums, axes=1)

    def _fits(self, sums):
        """
        Return theta (F + 1, k), its covariances and nuisances {joint: (F + 1, R)} beside it.

        Fitted without each fold, and at last to all blocks.
        """
        k = next(iter(sums.values()))[2].shape[1]
        matrix, vector, solved = np.eye(k), 0.0, {}
        for j, (cc, cd, cr) in sums.items():
            own, cross = self._joints[j], self._over_trains(cd)
            right = np.concatenate(
                [np.swapaxes(cross, 1, 2), self._over_trains(own.dr)[..., None]], axis=2)
            solved[j] = both = np.linalg.solve(self._trained(own), right)
            told = cross @ both
            matrix = matrix + self._over_trains(cc) - told[:, :, :k]
            vector = vector + self._over_trains(cr) - told[:, :, k]
        covariance = np.linalg.inv(matrix)
        theta = _times(covariance, vector)
        return theta, covariance, {j: both[:, :, k] - _times(both[:, :, :k], theta)
                                   for j, both in solved.items()}


@dataclass
class _Sums:
    """
    Sums of one joint per block: dd (B, R, R), dr (B, R), rr (B,).

    trained, left: what _trained and _left_by_nuisances made of them, once it was asked for. Blocks
    that share these sums have the same starts and folds.
    """

    dd: np.ndarray
    dr: np.ndarray
    rr: np.ndarray
    trained: np.ndarray | None = None
    left: np.ndarray | None = None

    def squares(self, delta):
        """Return the weighted squared residual (B,) after nuisances delta (B, R)."""
        return self.rr + ((_times(self.dd, delta) - 2.0 * self.dr) * delta).sum(axis=1)


def _times(matrices, vectors):
    """Return matrices (..., a, b) times vectors (..., b)."""
    return (matrices @ vectors[..., None])[..., 0]


def _squares(own, sums, delta, theta):
    """Return the weighted squared residual (B,) after nuisances delta (B, R), theta (B, k)."""
    cc, cd, cr = sums
    told = _times(cc, theta) + 2.0 * (_times(cd, delta) - cr)
    return own.squares(delta) + (told * theta).sum(axis=1)
