"""
Does the torque model's stated noise agree with the loads it finds where none is held?

The density read from block means is the largest over block lengths, a safe figure for whoever
watches the residual, but several times what an estimate of the load suffers from. Data left out
of an identification tell the latter: the load found in a window of them is wrong by
b = sum K^T W r, which by the statement has covariance S = sum K^T W K + G G^T (noise, and the
model's own uncertainty through G = sum K^T W N). For a consistent estimator b^T S^-1 b, the
normalised estimation error squared, is the rank of S on average; what it is of that is the share
of all stated variances that an estimate suffers from. Scaling all of them alike hardly moves the
estimate: only its prior, and noise measured online, weigh differently.
"""

from dataclasses import dataclass

import numpy as np

from ..torque_model import nuisance_columns

# Lengths [s] of windows: what an estimate is made from soon after the start of a motion and later.
WINDOWS = (5.0, 10.0, 20.0)
# Directions told less than this, in units of each parameter's own, are rounding.
LEAST_TOLD = 1e-9
# Windows of agreement at share 1 that are taken for granted: a short recording tells little.
ASSUMED = 1.0


@dataclass(frozen=True)
class LeftOut:
    """
    What identification found of recordings left out of it, each in turn.

    residual (N, n) [Nm]; part (N,): number of the part a row was left out with; covariances
    {part: (P, P)} of the parameters found without it.
    """

    residual: np.ndarray
    part: np.ndarray
    covariances: dict


@dataclass(frozen=True)
class Window:
    """
    Some seconds without load: N rows of n joints.

    load K (N, n, 10); uncertain (N, n, r): unit-variance uncertainties of the model; residual
    (N, n) [Nm]; weights (N, n) [1/Nm^2]: seconds of a row over the density of its residual.
    """

    load: np.ndarray
    uncertain: np.ndarray
    residual: np.ndarray
    weights: np.ndarray

    def squared_error(self):
        """
        Return b^T S^-1 b over the rank of S: 1 on average where the statement is true.

        NaN where the window tells nothing of a load.
        """
        load = self.load
        weighed = (load * self.weights[:, :, None]).reshape(-1, 10)
        error = self.residual.reshape(-1) @ weighed
        through = weighed.T @ self.uncertain.reshape(len(weighed), -1)
        covariance = weighed.T @ load.reshape(-1, 10) + through @ through.T
        square, rank = normalised_square(error, covariance)
        return square / rank if rank else np.nan


def normalised_square(error, covariance):
    """Return b^T S^-1 b and the rank of S for an error b (k,) of covariance S (k, k)."""
    # Masses and moments of inertia differ by orders of magnitude.
    unit = 1.0 / np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, axes = np.linalg.eigh(covariance * np.outer(unit, unit))
    # A standing arm, or one of few axes, tells nothing in some directions: b is zero there.
    told = values > LEAST_TOLD
    return float(np.sum((error * unit @ axes[:, told]) ** 2 / values[told])), int(told.sum())


def share_left_out(system, left_out, weights, drift):
    """
    Return the share of the stated variances at which loads found in a LeftOut err as stated.

    system: the System it was found with; weights (N, n) of its rows, drift (n, 3) as the
    recordings show it. The largest over lengths of windows, and a standard error more, is the safe
    one.
    """
    roots = {part: _root(covariance) for part, covariance in left_out.covariances.items()}

    def window(rows):
        columns = system.columns[rows]
        return Window(system.robot.load_columns(columns[:, :, :10 * system.robot.n]),
                      nuisance_columns(columns, roots[left_out.part[rows.start]], drift,
                                       *(values[rows] for values in system.drifting)),
                      left_out.residual[rows], weights[rows])

    shares = []
    for length in WINDOWS:
        squares = [window(rows).squared_error()
                   for rows in slices_of(system.dt, pieces_of(system, left_out), length)]
        squares = [square for square in squares if np.isfinite(square)]
        if len(squares) > 1:
            shares.append(share_of(squares) + np.std(squares) / np.sqrt(len(squares)))
    return float(max(shares, default=1.0))


def pieces_of(system, left_out):
    """Return numbers (N,) of rows of a System that belong together: in time, and in a LeftOut."""
    both = np.stack([system.owner, left_out.part])
    return np.unique(both, axis=1, return_inverse=True)[1].ravel()


def share_of(squares):
    """Return the mean of squared errors of Windows, with ASSUMED; 1 if there is none."""
    squares = np.asarray(squares)
    squares = squares[np.isfinite(squares)]
    return (np.sum(squares) + ASSUMED) / (len(squares) + ASSUMED)


def _root(covariance):
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.maximum(values, 0.0))


def slices_of(dt, part, length):
    """Return slices of `length` seconds of rows dt (N,) [s] apart, none across two parts (N,)."""
    edges = np.r_[0, np.flatnonzero(np.diff(part)) + 1, len(part)]
    out = []
    for first, stop in zip(edges[:-1], edges[1:]):
        count = np.floor(np.cumsum(dt[first:stop]) / length + 1e-9).astype(int)
        cuts = first + np.searchsorted(count, np.arange(count[-1] + 1))
        out += [slice(a, b) for a, b in zip(cuts[:-1], cuts[1:])]
    return out
