"""
How far a hidden effect is a load: the share of its torque that a load makes, and what that costs.

The arm is led along its own true motion without the effect (plant/led_plant.py), which tells the
torque that the effect adds. An oracle knows torque model, friction state and noise exactly, as the
Cramer-Rao bound does (bound.py), but of the effect nothing: it takes for a load what looks like
one, by weighted least squares. Its error is what no better model of the arm as it was spares; who
doubts the model may err less. The same oracle that lets every joint's offset, Coulomb and viscous
friction be anything tells what such doubt brings. What no estimator beats is the bound of one who
knows the shape of the effect's torque and only its size not: where that is wide, the effect is a
load to everybody.
"""

from dataclasses import asdict, dataclass

import numpy as np

from ..effects.smooth_sign import sign_of
from ..estimators.load_prior import load_prior
from ..load import products_jacobian_of_shape
from ..plant.run import JointEvent
from ..torque_model import DRIFTS, nuisance_columns
from .bound import shape_of
from .cases import case_arguments, case_motion, hidden_effects
from .effect_errors import MOVING, rms
from .effect_floor import led_along

# An effect that adds less than this share of the noise in every joint did not happen in this run:
# the led arm's longer steps of friction leave 0.005.
FAINT = 0.02
# Chance: so many parts of the run by whose lengths the torque is turned round in time.
TURNS = 8
# Directions of a load whose torque is below this share of the strongest's are not felt.
_FELT = 1e-9


@dataclass(frozen=True)
class AddedTorque:
    """
    What an effect adds along the true motion of an arm with a load, at N moments.

    stamp (N,) [s]; torque (N, n) [Nm], before noise; load (N, n, 10): columns K of a load's
    products; joints (N, n, 3 n) [Nm]: columns of each joint's offset, Coulomb and viscous
    friction, of size one where they are as large as the joint's greatest torque; precision (N, n)
    [1/Nm^2] of a message, zero where a joint stands, whose friction may hold anything.
    """

    stamp: np.ndarray
    torque: np.ndarray
    load: np.ndarray
    joints: np.ndarray
    precision: np.ndarray


@dataclass(frozen=True)
class Likeness:
    """
    How much of a torque a load makes, NaN where there is none.

    share [-]: of its weighted square, what some load's products make; chance [-]: the same of
    the torque turned round in time, which belongs to other poses; rest [-]: RMS of what no load
    makes, before the motion filter, over what the torque model leaves of the arm as it was, in the
    joint that shows it most.
    """

    share: float
    chance: float
    rest: float


def oracle_of(robot, load, model, added, stamps):
    """
    Return the plain figures of an AddedTorque where a load is held (LoadParameters).

    model: the TorqueModel of the arm as it was; stamps [s]: moments of the estimates. Those of
    Likeness; at the moments mass, mass_free [kg]: the oracle's error, without and with freedom of
    the joints, and mass_bound [kg]: the Cramer-Rao bound of who knows the effect but its size.
    """
    return {**asdict(likeness(added, model.noise)), **mass_figures(robot, load, added, stamps)}


def added_torque(robot, case):
    """Return the AddedTorque of what a Case hides, in its own run."""
    plant, led, following = led_along(
        robot, case_motion(robot, case), hidden_effects(robot, case), **case_arguments(case))
    stamp, torque, load, speed = [], [], [], []
    for event in following:
        if not isinstance(event, JointEvent):
            continue
        q, v, a, _ = plant.state()
        stamp.append(event.stamp)
        torque.append(plant.reported_effort() - led.follow(plant))
        load.append(robot.load_regressor(q, v, a))
        speed.append(v)
    speed = np.array(speed)
    return AddedTorque(
        np.array(stamp), np.array(torque), np.array(load), _joint_columns(robot, speed),
        (np.abs(speed) > MOVING) / plant.noise ** 2)


def _joint_columns(robot, v):
    """Return (N, n, 3 n) as of AddedTorque for velocities (N, n)."""
    nothing = np.zeros((*v.shape, 0)), np.zeros((0, 0))
    anything = np.repeat(robot.limits.torque[:, None], DRIFTS, axis=1)
    return nuisance_columns(*nothing, anything, sign_of(v), v)


def likeness(added, left):
    """Return the Likeness of an AddedTorque; left (n,) [Nm]: RMS that the model leaves."""
    root, moving = np.sqrt(added.precision), added.precision > 0.0
    if rms([root * added.torque], [moving]).max() < FAINT:
        return Likeness(*[float('nan')] * 3)
    made, size, axes = np.linalg.svd((root[..., None] * added.load).reshape(-1, 10),
                                     full_matrices=False)
    felt = size > _FELT * size[0]
    made, axes = made[:, felt], axes[felt] / size[felt, None]

    def share(torque):
        """Return the share of a torque (N, n) that a load makes."""
        seen = (root * torque).ravel()
        return float(np.sum((made.T @ seen) ** 2) / max(seen @ seen, 1e-300))

    turned = [np.roll(added.torque, k * len(added.torque) // TURNS, axis=0)
              for k in range(1, TURNS)]
    products = axes.T @ (made.T @ (root * added.torque).ravel())
    rest = rms([added.torque - added.load @ products], [moving]) / left
    return Likeness(share(added.torque), float(np.mean([share(other) for other in turned])),
                    float(rest.max()))


def mass_figures(robot, load, added, stamps):
    """
    Return {figure: list [kg] by stamp [s]} of the mass of a load; see oracle_of.

    load: the LoadParameters that are held. Linear about them, with the prior of everybody; that
    its mean is another load is no matter of the effect.
    """
    prior = load_prior(robot).std
    # In units of the prior, which is 1 in every direction; the effect's torque is the last.
    columns = np.concatenate([
        added.load @ (products_jacobian_of_shape(shape_of(load)) * prior), added.joints,
        added.torque[:, :, None]], axis=2)
    sums, before, out = np.zeros(2 * columns.shape[2:]), 0, []
    for stamp in stamps:
        until = int(np.searchsorted(added.stamp, stamp + 1e-9))
        rows = columns[before:until].reshape(-1, len(sums))
        sums = sums + (rows.T * added.precision[before:until].ravel()) @ rows
        before = until
        out.append((_taken_for(sums, 10), _taken_for(sums, len(sums) - 1), _bound(sums)))
    return {name: (prior[0] * np.array(figures)).tolist()
            for name, figures in zip(('mass', 'mass_free', 'mass_bound'), zip(*out))}


def _taken_for(sums, known):
    """Return what of the last column is taken for the first of so many columns' unknowns."""
    return np.linalg.solve(sums[:known, :known] + np.eye(known), sums[:known, -1])[0]


def _bound(sums):
    """Return the standard deviation of the first unknown where the last column's size is free."""
    shared = sums[:10, -1:]
    # Nothing is shared with an effect that has not acted yet.
    free = shared @ shared.T / max(sums[-1, -1], 1e-300)
    return np.sqrt(np.linalg.inv(sums[:10, :10] - free + np.eye(10))[0, 0])
