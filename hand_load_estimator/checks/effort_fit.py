"""Per joint: measured effort against the rigid body of the robot file and friction."""

from dataclasses import dataclass

import numpy as np

from .effort_terms import joint_columns, SIGN_WIDTH

# Standard deviations that make a sign certain.
CERTAIN = 4.0


@dataclass(frozen=True)
class JointFit:
    """
    effort = gain x rigid + Coulomb sgn(v) + viscous v + offset + rotor a, of one moving joint.

    gain, gain_std: Nm reported per Nm of the rigid body; friction, friction_std [Nm] at the mean
    speed, positive when it brakes; r2; residual [Nm] RMS; gravity_gain, gravity_gain_std: gain of
    the gravity part alone; gravity_rms [Nm]: how much gravity torque changes; spread: factor by
    which correlation in time widens a standard deviation.
    """

    gain: float
    gain_std: float
    friction: float
    friction_std: float
    r2: float
    residual: float
    gravity_gain: float
    gravity_gain_std: float
    gravity_rms: float
    spread: float

    @property
    def braking(self):
        """1 when friction brakes, -1 when it drives, 0 when that is not certain."""
        return int(np.sign(self.friction)) * (abs(self.friction) > CERTAIN * self.friction_std)


def regress(matrix, effort):
    """Return solution, covariance, residual and spread of a linear fit with coloured errors."""
    size = np.maximum(np.linalg.norm(matrix, axis=0), 1e-12)
    inverse = np.linalg.pinv(matrix / size, rcond=1e-7)
    solution = inverse @ effort / size
    residual = effort - matrix @ solution
    energy = max(residual @ residual, 1e-300)
    rho = np.clip(residual[1:] @ residual[:-1] / energy, 0.0, 0.98)
    spread = np.sqrt((1.0 + rho) / (1.0 - rho))
    covariance = spread**2 * residual.var() * (inverse @ inverse.T) / np.outer(size, size)
    return solution, covariance, residual, spread


def fit_joint(columns, gravity):
    """Return the JointFit of JointColumns for a gravity vector (3,)."""
    weight = columns.gravity @ gravity
    rigid = columns.inertial + weight
    solution, covariance, residual, spread = regress(
        np.column_stack([rigid, columns.nuisance]), columns.effort)
    speed = np.mean(np.abs(columns.nuisance[:, 1]))
    brake = np.array([0.0, np.tanh(speed / SIGN_WIDTH), speed, 0.0, 0.0])
    apart, apart_covariance, *_ = regress(
        np.column_stack([weight, columns.inertial, columns.nuisance]), columns.effort)
    return JointFit(
        gain=solution[0], gain_std=np.sqrt(covariance[0, 0]), friction=brake @ solution,
        friction_std=np.sqrt(brake @ covariance @ brake),
        r2=1.0 - residual.var() / max(columns.effort.var(), 1e-300),
        residual=residual.std(), gravity_gain=apart[0],
        gravity_gain_std=np.sqrt(apart_covariance[0, 0]), gravity_rms=weight.std(), spread=spread)


def fit_load_gain(bare, loaded, gravity):
    """
    Return gain and std of the load's torque in the effort, all moving joints together.

    bare, loaded: JointColumns of the same samples without and with the known load.
    1: the effort shows the load as it is; 0: it has been taken off.
    """
    gains, weights = [], []
    for without, carrying in zip(bare, loaded):
        if without is None:
            continue
        rigid = without.inertial + without.gravity @ gravity
        load = carrying.inertial + carrying.gravity @ gravity - rigid
        solution, covariance, *_ = regress(
            np.column_stack([load, rigid, without.nuisance]), without.effort)
        if covariance[0, 0] > 0.0:
            # The gain of the rigid body tells the unit; the load is compared in that unit.
            gains.append(solution[0] / solution[1])
            weights.append(solution[1]**2 / covariance[0, 0])
    if not weights:
        return np.nan, np.inf
    return float(np.average(gains, weights=weights)), float(1.0 / np.sqrt(np.sum(weights)))


def fit_delay(signals, terms, gravity, longest=0.1):
    """
    Return delay and std [s] of the effort against the position, NaN where it cannot be told.

    The delay is where the fit of all moving joints together leaves the least unexplained.
    """
    lags = np.linspace(-longest, longest, 21)
    misfits, count, spread = [], 0, 1.0
    for lag in lags:
        total = 0.0
        count, spreads = 0, []
        for columns in joint_columns(signals, terms, lag):
            if columns is not None:
                rigid = columns.inertial + columns.gravity @ gravity
                _, _, residual, spread = regress(np.column_stack([rigid, columns.nuisance]),
                                                 columns.effort)
                total += len(residual) * np.log(max(residual.var(), 1e-12))
                spreads.append(spread)
        misfits.append(total)
    best = int(np.argmin(misfits))
    if not 0 < best < len(lags) - 1:
        return np.nan, np.inf
    left, middle, right = misfits[best - 1:best + 2]
    step, bend = lags[1] - lags[0], left - 2.0 * middle + right
    # -2 log likelihood of a Gaussian: its second derivative is twice the information.
    std = np.mean(spreads) * step * np.sqrt(2.0 / bend) if bend > 0.0 else np.inf
    return float(lags[best] + 0.5 * step * (left - right) / bend), float(std)
