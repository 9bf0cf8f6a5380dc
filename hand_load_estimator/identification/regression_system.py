"""The least squares of identification: columns, torque and weights of recordings (eq. 11)."""

from copy import copy

import numpy as np

from ..effects import LATE
from ..effects.effect import SLOWEST
from ..torque.columns import (ColumnLayout, effect_columns, effect_slices, presliding_distances,
                              presliding_plastics, torque_columns)
from ..torque.contact_level import contact_level
from ..torque.lateness import as_reported, change_when_late
from ..torque.motion_inputs import known_motion, motion_inputs
from ..torque.presliding import stuck_density
from .evidence import recording_numbers
from .load_agreement import LeftOut

# Travels that differ by no more than this share need not be followed anew: how recordings tell
# them is no better.
ALIKE = 0.02
# What a joint's friction began with is forgotten where it is in doubt by less than this [-].
FORGOTTEN = 0.1


class System:
    """
    Columns, torque and friction doubt of several recordings for one set of effects.

    mean (P,): parameters that tell torques to the effects that depend on them, and how travels go
    with temperature; around these the torque of a delay, which is a product of its share and all
    others, is made linear. drifting: friction state and velocity (N, n) of the moments that the
    torques belong to. inputs: the motion_inputs of the evidence, where they are known, with the
    travels of `mean`, or nearly so.
    """

    def __init__(self, robot, uses, evidence, mean, inputs=None):
        self.robot = robot
        layout = ColumnLayout(robot.n, uses)
        self._level = contact_level(robot, uses, mean)
        inputs = inputs or next(motion_inputs(
            robot, [e.motion for e in evidence], [ways_to_turn(robot.n, uses)], self._level))
        self._inputs = [x for x, _ in inputs]
        self.columns = np.concatenate([
            torque_columns(robot, layout, x, mean, e.motion.dt, e.load,
                           links=known_motion(robot, e.motion).links)
            for (x, _), e in zip(inputs, evidence)])
        self.torque = np.concatenate([e.torque for e in evidence])
        self.doubt = np.concatenate([doubt for _, doubt in inputs])
        self.tells = np.concatenate([e.tells for e in evidence])
        self.dt = np.concatenate([e.motion.dt for e in evidence])
        self.owner = np.concatenate([np.full(len(e.torque), k) for k, e in enumerate(evidence)])
        self.recording = np.concatenate([
            np.full(len(e.torque), k) for k, e in zip(recording_numbers(evidence), evidence)])
        self.velocity = np.concatenate([x.v for x, _ in inputs])
        self.z = np.concatenate([x.z for x, _ in inputs])
        self._uses = uses
        self.drifting = self.z.copy(), self.velocity.copy()
        self._drift = None
        # A delay delays every other column of its joint; none counts twice.
        self._late = {use.joint: (mean[where][0], use.shape['shift'])
                      for use, where in effect_slices(robot.n, uses) if use.name == LATE}
        for j in self._late:
            for values in self.drifting:
                values[:, j:j + 1] += self._change(values[:, j:j + 1], j)
            change = self._change(self.columns[:, j, layout.prompt], j)
            self.columns[:, j, layout.prompt] += change
            self.torque[:, j] += change @ mean[layout.prompt]

    def _change(self, columns, j):
        """Return what the delay of joint j changes of its columns (N, k)."""
        share, delay = self._late[j]
        return share * change_when_late(columns, self.dt, self.owner, delay)

    def columns_of(self, use):
        """Return the columns (N, k) of an effect that reads no torques."""
        columns = np.concatenate([effect_columns(x, use) for x in self._inputs])
        return columns + self._change(columns, use.joint) if use.joint in self._late else columns

    def reshape(self, use, where):
        """Write the columns of such an effect anew; where: its slice of x."""
        self.columns[:, use.joint, where] = self.columns_of(use)

    def levels_hold(self, uses, x):
        """Tell whether contacts bend up to levels as x (P,) of uses says, or nearly so."""
        warmth = np.concatenate([inputs.warmth for inputs in self._inputs])
        own, other = ((1.0, 0.0) if level is None else (level.warmed(warmth), level.share)
                      for level in (self._level, contact_level(self.robot, uses, x)))
        return bool(np.abs(other[0] / own[0] - 1.0).max() < ALIKE
                    and np.abs(other[1] - own[1]).max() < ALIKE)

    def with_more(self, columns):
        """Return a System with columns (N, n, k) behind its own."""
        out = copy(self)
        out.columns = np.concatenate([self.columns, columns], axis=2)
        return out

    def with_drift(self, drift):
        """
        Return a System whose recordings each have an offset, level and coefficient of their own.

        drift (n, 3): their std. What they may do is no more told by the recordings than so (a
        random effect, marginalised), and is part of what the parameters are not known by. A single
        recording is the same: its quarters are too short to tell drift from all else.
        """
        out = copy(self)
        out._drift = drift if len(np.unique(self.recording)) > 1 else None
        return out

    def weights(self, intensity, friction):
        """Return (N, n): dt / density, less where friction is in doubt, 0 where nothing tells."""
        stuck = stuck_density(self.z, self.doubt, self.velocity, friction)
        stuck = as_reported(self._uses, stuck, self.dt, self.owner)
        return np.where(self.tells, self.dt[:, None] / (intensity + stuck), 0.0)

    def turning_weights(self, intensity):
        """Return (N, n): dt / density where joints move that have forgotten how they began."""
        known = (self.doubt < FORGOTTEN) & (np.abs(self.velocity) > SLOWEST) & self.tells
        return np.where(known, self.dt[:, None] / intensity, 0.0)

    def solve(self, mean, covariance, weights):
        """Return the posterior mean and covariance of x (eq. 11)."""
        return posterior_of(mean, covariance, self.told(mean, covariance, weights, slice(None)))

    def told(self, mean, covariance, weights, rows):
        """Return Y^T W Y and Y^T W (tau - Y mean) of rows, for the parameters free to move."""
        y, tau, w = self.columns[rows], self.torque[rows], weights[rows]
        n, free = tau.shape[1], np.flatnonzero(np.diag(covariance) > 0.0)
        information = np.zeros((len(free), len(free)))
        gradient = np.zeros(len(free))
        for j in range(n):
            # A joint tells nothing of the others' effects and of the links before it.
            own = np.flatnonzero(y[:, j, free].any(axis=0))
            yj = y[:, j, free[own]]
            weighted, left = yj * w[:, j, None], tau[:, j] - y[:, j] @ mean
            information[np.ix_(own, own)] += weighted.T @ yj
            gradient[own] += weighted.T @ left
            for own_rows, unit, certain in self._drifting(w, j, rows):
                through = weighted[own_rows].T @ unit
                information[np.ix_(own, own)] -= through @ certain @ through.T
                gradient[own] -= through @ certain @ (unit.T @ (w[own_rows, j] * left[own_rows]))
        return information, gradient

    def _drifting(self, weights, j, rows):
        """
        Yield of each recording its rows, and the columns of joint j's drift in units of its std.

        The third is the covariance (3, 3) of what these rows of weights (N, n) leave of it.
        """
        if self._drift is None:
            return
        columns = self._drift[j] * np.stack(
            [np.ones(len(weights)), *(values[rows, j] for values in self.drifting)], axis=1)
        recording = self.recording[rows]
        for number in np.unique(recording):
            own = np.flatnonzero(recording == number)
            unit = columns[own]
            yield own, unit, np.linalg.inv((unit * weights[own, j, None]).T @ unit + np.eye(3))

    def residual(self, x):
        """Return tau - Y x, (N, n)."""
        return self.torque - self.columns @ x


def ways_to_turn(n, uses):
    """Return the travels [rad] over which n joints' friction turns, and where it yields (n,)."""
    return presliding_distances(n, uses), presliding_plastics(n, uses)


def posterior_of(mean, covariance, told):
    """Return posterior mean (P,) and covariance (P, P) of a prior and what data told of it."""
    information, gradient = told
    free = np.flatnonzero(np.diag(covariance) > 0.0)
    root = _root(covariance[np.ix_(free, free)])
    inverse = np.linalg.inv(root.T @ information @ root + np.eye(len(free)))
    posterior = np.zeros_like(covariance)
    posterior[np.ix_(free, free)] = root @ (0.5 * (inverse + inverse.T)) @ root.T
    x = mean.copy()
    x[free] += root @ (inverse @ (root.T @ gradient))
    return x, posterior


def _root(covariance):
    """Return R (k, k) with R R^T = covariance."""
    # Scaling by the standard deviations keeps masses and inertias of small links in one range.
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))


def held_out(system, mean, covariance, weights):
    """
    Return the LeftOut of data left out of the fit: each recording in turn.

    A single recording is cut into four parts in time instead.
    """
    parts = system.recording
    if len(np.unique(parts)) == 1:
        parts = np.arange(len(parts)) * 4 // len(parts)
    told = {part: system.told(mean, covariance, weights, np.flatnonzero(parts == part))
            for part in np.unique(parts)}
    residual, covariances = np.empty_like(system.torque), {}
    for part in told:
        rest = [sum(sums) for sums in zip(*(told[k] for k in told if k != part))]
        x, covariances[part] = posterior_of(mean, covariance, rest)
        rows = parts == part
        residual[rows] = system.torque[rows] - system.columns[rows] @ x
    return LeftOut(residual, parts, covariances)
