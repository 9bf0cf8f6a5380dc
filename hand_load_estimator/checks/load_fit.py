"""What load does the effort look like, taking the robot file at its word."""

from dataclasses import dataclass

import numpy as np

from .effort_fit import regress
from .effort_terms import BAND, SIGN_WIDTH
from .motion import STANDING
from .signals import low_pass

_REWEIGHTINGS = 4


@dataclass(frozen=True)
class LoadFit:
    """mass, std [kg]; com (3,) [m] in the load frame. The std knows nothing of wrong links."""

    mass: float
    std: float
    com: np.ndarray


def _joint_system(signals, excess, regressor, j, step):
    """Return effort beyond the links (M,) and columns (M, 4) of a joint, less friction."""
    v = signals.v[:, j]
    columns = np.column_stack([excess[:, j], regressor[:, j], np.tanh(v / SIGN_WIDTH), v,
                               np.ones_like(v), signals.a[:, j]])
    columns = low_pass(columns, signals.rate, BAND)[::step]
    columns = columns[np.abs(v[::step]) > STANDING]
    basis, size, _ = np.linalg.svd(columns[:, 5:], full_matrices=False)
    basis = basis[:, size > 1e-8 * size[0]]
    columns = columns[:, :5] - basis @ (basis.T @ columns[:, :5])
    return columns[:, 0], columns[:, 1:]


def fit_load(signals, robot, terms, moving):
    """
    Return the LoadFit of the moving joints together.

    terms: RigidTerms without a load. Mass and mass x com only: the inertia of a load hardly shows.
    """
    step = max(1, int(signals.rate / (2.0 * BAND)))
    excess = signals.effort - terms.inertial - terms.gravity @ np.array(robot.file.gravity)
    regressor = np.array([robot.load_regressor(q, v, a)[:, :4]
                          for q, v, a in zip(signals.q, signals.v, signals.a)])
    systems = [_joint_system(signals, excess, regressor, j, step) for j in moving]
    scales = np.ones(len(systems))
    for _ in range(_REWEIGHTINGS):
        matrix = np.vstack([a / s for (_, a), s in zip(systems, scales)])
        effort = np.concatenate([y / s for (y, _), s in zip(systems, scales)])
        solution, covariance, *_ = regress(matrix, effort)
        scales = [max(np.std(y - a @ solution), 1e-3) for y, a in systems]
    com = solution[1:] / solution[0] if abs(solution[0]) > 1e-6 else np.zeros(3)
    return LoadFit(float(solution[0]), float(np.sqrt(covariance[0, 0])), com)
