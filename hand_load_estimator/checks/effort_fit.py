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
    the gravity part alone (std infinite where gravity hardly changes); gravity_rms, rigid_rms
    [Nm]: how much gravity and the whole rigid body's torque change; spread: factor by which
    correlation in time widens a std.
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
    rigid_rms: float
    spread: float

    @property
    def told(self):
        """Whether the recording tells the gain: the rigid body stands out of what is unknown."""
        return (self.gain_std < 0.15 * max(1.0, abs(self.gain))
                and self.rigid_rms > 3.0 * self.residual)

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
    if rigid.std() < 1e-3 * columns.effort.std():
        covariance[0, 0] = np.inf
    speed = np.mean(np.abs(columns.nuisance[:, 1]))
    brake = np.array([0.0, np.tanh(speed / SIGN_WIDTH), speed, 0.0, 0.0])
    apart, apart_covariance, *_ = regress(
        np.column_stack([weight, columns.inertial, columns.nuisance]), columns.effort)
    return JointFit(
        gain=solution[0], gain_std=np.sqrt(covariance[0, 0]), friction=brake @ solution,
        friction_std=np.sqrt(brake[1:] @ covariance[1:, 1:] @ brake[1:]),
        r2=1.0 - residual.var() / max(columns.effort.var(), 1e-300),
        residual=residual.std(), gravity_gain=apart[0],
        gravity_gain_std=(np.sqrt(apart_covariance[0, 0])
                          if weight.std() > 0.01 * columns.effort.std() else np.inf),
        gravity_rms=weight.std(), rigid_rms=rigid.std(), spread=spread)


def _misfit(signals, terms, gravity, joints, late, slowest):
    """Return -2 log likelihood of the joints' fits with effort read `late` [s], and the spread."""
    columns = joint_columns(signals, terms, late, slowest)
    misfit, spreads = 0.0, []
    for j in joints:
        rigid = columns[j].inertial + columns[j].gravity @ gravity
        _, _, residual, spread = regress(np.column_stack([rigid, columns[j].nuisance]),
                                         columns[j].effort)
        misfit += len(residual) * np.log(max(residual.var(), 1e-12))
        spreads.append(spread)
    return misfit, np.mean(spreads)


def fit_delay(signals, terms, gravity, joints, slowest, longest=0.1):
    """
    Return delay and std [s] of the effort against the position, std infinite when it cannot tell.

    The delay is where the fits of the joints asked for, which move faster than slowest (n,)
    [rad/s], leave the least unexplained.
    """
    lags = np.linspace(-longest, longest, 21)
    misfits, spreads = zip(*(_misfit(signals, terms, gravity, joints, lag, slowest)
                             for lag in lags))
    best = int(np.argmin(misfits))
    if not 0 < best < len(lags) - 1:
        return np.nan, np.inf
    left, middle, right = misfits[best - 1:best + 2]
    step, bend = lags[1] - lags[0], left - 2.0 * middle + right
    if bend <= 0.0:
        return np.nan, np.inf
    # The second derivative of -2 log likelihood is twice the information.
    std = spreads[best] * step * np.sqrt(2.0 / bend)
    return float(lags[best] + 0.5 * step * (left - right) / bend), float(std)
