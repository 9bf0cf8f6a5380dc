"""The torques of the robot file's rigid body, in the shape the checks of the effort need."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from .motion import moving, STANDING
from .signals import low_pass

# [Hz] below it are the motions, above it noise and what a rigid body does not know.
BAND = 4.0
# [rad/s] over which Coulomb friction changes sign in the fit.
SIGN_WIDTH = 0.03


@dataclass(frozen=True)
class RigidTerms:
    """inertial (N, n): torque without gravity [Nm]; gravity (N, n, 3): torque per m/s^2."""

    inertial: np.ndarray
    gravity: np.ndarray


@dataclass(frozen=True)
class JointColumns:
    """
    Band-limited columns (M,) of one joint, samples in which it moves.

    effort (as torque by the robot file) [Nm], inertial [Nm], gravity (M, 3) [Nm per m/s^2],
    nuisance (M, 4): Coulomb sign, velocity, one, acceleration.
    """

    effort: np.ndarray
    inertial: np.ndarray
    gravity: np.ndarray
    nuisance: np.ndarray


def _model(robot, load):
    model = pin.Model(robot.model)
    if load is not None and load.mass > 0.0:
        placement = model.frames[model.getFrameId(robot.load_frame)].placement
        body = pin.Inertia(load.mass, np.array(load.com), np.array(load.inertia))
        model.inertias[robot.n] = model.inertias[robot.n] + placement.act(body)
    return model


def rigid_terms(robot, signals, load=None):
    """Return the RigidTerms of the nominal arm, with an optional LoadParameters in its hand."""
    model = _model(robot, load)
    data, zero = model.createData(), np.zeros(robot.n)
    gravity = np.empty(signals.q.shape + (3,))
    for k in range(3):
        model.gravity.linear = np.eye(3)[k]
        gravity[:, :, k] = [pin.rnea(model, data, q, zero, zero).copy() for q in signals.q]
    model.gravity.linear = np.zeros(3)
    inertial = np.array([pin.rnea(model, data, q, v, a).copy()
                         for q, v, a in zip(signals.q, signals.v, signals.a)])
    return RigidTerms(inertial, gravity)


def joint_columns(signals, terms, late=0.0, slowest=None):
    """
    Return the JointColumns of each joint, None for one that does not move.

    `late` [s]: the effort is read that much later than the rest; slowest (n,) [rad/s]: slower
    samples count as standing, by default those below STANDING.
    """
    slowest = np.full(signals.q.shape[1], STANDING) if slowest is None else slowest
    moves, step = moving(signals, slowest), max(1, int(signals.rate / (2.0 * BAND)))
    return [_joint(signals, terms, j, late, step, slowest[j]) if moves[j] else None
            for j in range(signals.q.shape[1])]


def _joint(signals, terms, j, late, step, slowest):
    v = signals.v[:, j]
    effort = np.interp(signals.time + late, signals.time, signals.effort[:, j])
    columns = np.column_stack([effort, terms.inertial[:, j], terms.gravity[:, j],
                               np.tanh(v / SIGN_WIDTH), v, np.ones_like(v), signals.a[:, j]])
    columns = low_pass(columns, signals.rate, BAND)[::step]
    columns = columns[np.abs(v[::step]) > slowest]
    return JointColumns(columns[:, 0], columns[:, 1], columns[:, 2:5], columns[:, 5:])
