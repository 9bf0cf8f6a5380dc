"""What a residual does all the time, to be told from what happens once."""

import numpy as np

from ...identification.identify import prior
from ..tracing.hypothesis import EFFECT_FACTOR
from ..tracing.plain_functions import hats

KNOTS = 16
# What plain functions and a recording's own friction may do, in units of the joint's torque limit.
SIZE = 0.1


class Usual:
    """
    Nuisances of a Residual that last: the model's own parameters, functions of the motion, drift.

    basis (N, n, R): their columns B, scaled so that refitting them beside weighted columns C
    takes (B^T W C)^T (B^T W C) from C^T W C; rest (N, n) [Nm]: residual after their fit; weights
    (N, n) as of Residual.
    """

    def __init__(self, model, residual):
        self._columns = _columns(model, residual)
        self._residual = residual.residual
        self.fit(residual.weights)

    def fit(self, weights):
        """Fit all anew with other weights (N, n), zero where a row is to be left out."""
        self.weights, self.rest = weights, np.empty_like(self._residual)
        size = max(columns.shape[1] for columns in self._columns)
        self.basis = np.zeros((*self._residual.shape, size))
        for j, columns in enumerate(self._columns):
            weighted = columns * weights[:, j, None]
            lower = np.linalg.cholesky(weighted.T @ columns + np.eye(columns.shape[1]))
            basis = np.linalg.solve(lower, columns.T).T
            fitted = basis.T @ (weights[:, j] * self._residual[:, j])
            self.basis[:, j, :columns.shape[1]] = basis
            self.rest[:, j] = self._residual[:, j] - basis @ fitted


def _columns(model, residual):
    """Return a list of (N, R_j): columns in units of what each may be."""
    robot, x = model.robot, residual.x
    variance = np.diag(prior(robot, model.uses, True)[1])
    own = residual.blocks(EFFECT_FACTOR * np.diag(np.sqrt(variance))).nuisances
    recordings = (residual.owner[:, None] == np.unique(residual.owner)).astype(float)
    out = []
    for j in range(robot.n):
        z, v = x.z[:, j], x.v[:, j]
        plain = [hats(values[:, j], KNOTS) for values in (x.q, x.v)]
        drift = [recordings * values[:, None] for values in (np.ones_like(z), z, v)]
        warm = x.warmth[:, j, None] * np.stack([z, v], axis=1) / 20.0
        functions = np.hstack([*plain, *drift, warm])
        out.append(np.hstack([own[j], SIZE * robot.limits.torque[j] * functions]))
    return out
