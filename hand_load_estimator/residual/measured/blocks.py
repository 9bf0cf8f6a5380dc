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
        delta = np.linalg.solve(own.dd.sum(axis=0) + np.eye(d.shape[1]), told)
        return self.residual[:, j] - d @ delta

    def misfit(self, j):
        """Return the nats (G,) that held-out blocks of joint j are off by beside the nuisances."""
        out = np.zeros(len(self.starts))
        for fold in np.unique(self.folds):
            test = self.folds == fold
            out[test] = 0.5 * self._joints[j].squares(test, self._null(j, fold))
        return np.bincount(self._groups, out)

    def evaluate(self, columns):
        """Return the Score of columns {joint: (N, k)}, in units of their prior's std."""
        sums = {j: self._cross(j, c) for j, c in columns.items()}
        gains, by_joint = np.zeros(len(self.starts)), dict.fromkeys(columns, 0.0)
        for fold in np.unique(self.folds):
            train, test = self.folds != fold, self.folds == fold
            theta, _, deltas = self._fit(sums, train)
            for j, (cc, cd, cr) in sums.items():
                own = self._joints[j]
                gain = 0.5 * (own.squares(test, self._null(j, fold))
                              - _squares(own, (cc, cd, cr), test, deltas[j], theta))
                gains[test] += gain
                by_joint[j] += gain.sum()
        theta, covariance, _ = self._fit(sums, np.ones(len(self.starts), dtype=bool))
        gains = np.bincount(self._groups, gains)
        std = np.sqrt(len(gains)) * gains.std()
        return Score(gains.sum(), std, gains, theta, covariance, by_joint)

    def _joint(self, j):
        d, w = self.nuisances[j], self.weights[:, j]
        r = self.residual[:, j]
        dd, dr, rr = [], [], []
        for a, b in zip(self.starts, self._ends):
            wd = d[a:b] * w[a:b, None]
            dd.append(wd.T @ d[a:b])
            dr.append(wd.T @ r[a:b])
            rr.append(float((w[a:b] * r[a:b]) @ r[a:b]))
        return _Sums(np.array(dd), np.array(dr), np.array(rr), {})

    def _cross(self, j, columns):
        weighted = columns * self.weights[:, j, None]
        k, r = columns.shape[1], self.nuisances[j].shape[1]
        right = np.column_stack([columns, self.nuisances[j], self.residual[:, j]])
        sums = np.array([weighted[a:b].T @ right[a:b] for a, b in zip(self.starts, self._ends)])
        return sums[:, :, :k], sums[:, :, k:k + r], sums[:, :, k + r]

    def _null(self, j, fold):
        own = self._joints[j]
        if fold not in own.null:
            train = self.folds != fold
            own.null[fold] = np.linalg.solve(
                own.dd[train].sum(axis=0) + np.eye(own.dd.shape[1]), own.dr[train].sum(axis=0))
        return own.null[fold]

    def _fit(self, sums, train):
        k = next(iter(sums.values()))[2].shape[1]
        matrix, vector, solved = np.eye(k), np.zeros(k), {}
        for j, (cc, cd, cr) in sums.items():
            own = self._joints[j]
            dd = own.dd[train].sum(axis=0) + np.eye(own.dd.shape[1])
            cross = cd[train].sum(axis=0)
            both = np.linalg.solve(dd, np.column_stack([cross.T, own.dr[train].sum(axis=0)]))
            matrix += cc[train].sum(axis=0) - cross @ both[:, :k]
            vector += cr[train].sum(axis=0) - cross @ both[:, k]
            solved[j] = both
        covariance = np.linalg.inv(matrix)
        theta = covariance @ vector
        return theta, covariance, {j: both[:, k] - both[:, :k] @ theta
                                   for j, both in solved.items()}


@dataclass
class _Sums:
    """Sums of one joint per block: dd (B, R, R), dr (B, R), rr (B,); null fits per fold."""

    dd: np.ndarray
    dr: np.ndarray
    rr: np.ndarray
    null: dict

    def squares(self, blocks, delta):
        """Return the weighted squared residual of some blocks after nuisances delta."""
        return (self.rr[blocks] - 2.0 * self.dr[blocks] @ delta
                + np.einsum('i,bij,j->b', delta, self.dd[blocks], delta))


def _squares(own, sums, blocks, delta, theta):
    cc, cd, cr = (part[blocks] for part in sums)
    return (own.squares(blocks, delta) - 2.0 * cr @ theta
            + 2.0 * np.einsum('i,bij,j->b', theta, cd, delta)
            + np.einsum('i,bij,j->b', theta, cc, theta))
