"""The no-load torque difference in recordings: what functions of it learn from (E2.1, E2.5)."""

from dataclasses import dataclass

import numpy as np

from ..identification.regression_system import System
from ..torque.columns import warmth_of
from .difference_inputs import difference_inputs


@dataclass(frozen=True)
class DifferenceData:
    """
    Samples of tau_real - tau_mdl without load, or less the torque of a known load (E2.5).

    That torque is linear in the load (eq. 10), so what is learned with it is what is learned
    without. names: inputs used; inputs (N, n, D); difference (N, n) as multiples of scale (n,)
    [Nm]; worth (N, n): what a sample counts beside an independent one, because neighbours share
    their error and stuck joints hide theirs; owner (N,): its recording; dt (N,) [s].
    """

    names: tuple
    inputs: np.ndarray
    difference: np.ndarray
    scale: np.ndarray
    worth: np.ndarray
    owner: np.ndarray
    dt: np.ndarray


def difference_data(model, evidence, names):
    """Return the DifferenceData of a TorqueModel over a list of Evidence."""
    robot, residuals = model.robot, model.residuals
    system = System(robot, model.uses, evidence, model.mean)
    q, v, a, temperature = (np.concatenate([getattr(e.motion, part) for e in evidence])
                            for part in ('q', 'v', 'a', 'temperature'))
    weights = system.weights(residuals.intensity, model.friction_level())
    return DifferenceData(
        tuple(names), difference_inputs(names, q, v, a, warmth_of(robot, temperature)),
        system.residual(model.mean) / residuals.rmse, residuals.rmse,
        np.minimum(weights * residuals.rmse ** 2, 1.0), system.owner, system.dt)
