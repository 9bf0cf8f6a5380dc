"""
The torque model: rigid body + declared effects, all linear in one parameter vector.

tau_mdl = Y(theta, theta', theta'') x, where x holds the links' products (10 n) followed by the
effects' parameters, joint by joint.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .effects import EffectInput, LATE
from .robot import Robot
from .torque.columns import (ColumnLayout, effect_slices, first_of_joints, presliding_distances,
                             presliding_plastics, tilt_along, torque_columns, warmth_of)
from .torque.contact_level import contact_level, friction_level
from .torque.link_pull import link_pull
from .torque.load_through_effects import load_while_sliding

# Offset, Coulomb level and viscous coefficient of each joint drift from run to run.
DRIFTS = 3
# Without a sensor a joint is anywhere between cold and warm [K, one standard deviation].
UNKNOWN_WARMTH = 12.0
# Effects of temperature, and which of a joint's drifts an unknown temperature looks like.
WARMED = {'temperature_dependent_coulomb_friction': 1,
          'temperature_dependent_viscous_friction': 2}


@dataclass(frozen=True)
class Residuals:
    """
    What the model does not explain, per joint (n,).

    rmse [Nm]: of the filtered torque on held-out data, while joints slide; of joints that no
    recording moved as much as may be left of friction. intensity [Nm^2 s]: spectral density of
    the residual at low frequencies; over t seconds an average of it has variance intensity / t,
    which is what coloured residuals do to an estimate. drift (n, 3) [Nm, Nm, Nm s/rad]: standard
    deviation from day to day of offset, Coulomb level and viscous coefficient. sliding [Nm]:
    of means over fractions of a second while the joint slides (sliding.py), on data not
    used for the fit, at the last diagnosis; NaN for a joint without motion then, or None.
    load_share: of all variances the model states, what an estimate of the load suffers from
    (load_agreement.py). unmoved (n,) bool: joints that no recording moved, or None for none.
    """

    rmse: np.ndarray
    intensity: np.ndarray
    drift: np.ndarray
    sliding: np.ndarray | None = None
    load_share: float = 1.0
    unmoved: np.ndarray | None = None

    @property
    def load_intensity(self):
        """Density (n,) [Nm^2 s] by which an estimate of the load weighs its samples."""
        return self.load_share * self.intensity


@dataclass(frozen=True)
class TorqueModel:
    """
    An identified (or nominal) torque model of one robot.

    uses: EffectUse in the order of their columns; links_declared: whether the links' products
    were identified; mean (P,), covariance (P, P) of x; residuals; recordings it came from, a
    RecordingMark each; temperatures: (low, high) [degC] seen, or None; diagnosed: ISO 8601 time at
    which it was last held against recordings, by identification or diagnosis, or None.
    """

    robot: Robot
    uses: tuple
    links_declared: bool
    mean: np.ndarray
    covariance: np.ndarray
    residuals: Residuals
    recordings: tuple = ()
    temperatures: tuple | None = None
    diagnosed: str | None = None

    @property
    def noise(self):
        """RMS (n,) [Nm] of the torque the model leaves unexplained."""
        return self.residuals.rmse

    @property
    def recording_names(self):
        """Names of the recordings it came from."""
        return [mark.name for mark in self.recordings]

    def presliding_distance(self):
        """Return the travel (n,) [rad] over which each joint's friction turns at the reference."""
        return presliding_distances(self.robot.n, self.uses)

    def presliding_plastic(self):
        """Return of which last of the way between two levels (n,) each joint's contacts yield."""
        return presliding_plastics(self.robot.n, self.uses)

    def contact_level(self):
        """Return the ContactLevel of the joints, None where nothing moves their levels."""
        return contact_level(self.robot, self.uses, self.mean)

    def friction_level(self):
        """Return the largest sliding friction (n,) [Nm] at low speed, reference temperature."""
        return friction_level(self.robot.n, self.uses, self.mean)

    def friction_doubt(self):
        """Return the standard deviation (n,) [Nm] of each joint's Coulomb level."""
        return np.sqrt(self._of_joints('coulomb_friction', self.covariance.diagonal()))

    def held_friction(self):
        """
        Return what a joint that stands may hold (n,) [Nm]: friction_level and its own doubt.

        A joint that never moved in the recordings has no level, and holds friction all the same.
        """
        return np.hypot(self.friction_level(), self.friction_doubt())

    def viscous_friction(self):
        """Return each joint's viscous coefficient (n,) [Nm s/rad], reference temperature."""
        return self._of_joints('viscous_friction', self.mean)

    def _of_joints(self, name, values):
        return first_of_joints(self.robot.n, self.uses, name, values)

    @cached_property
    def layout(self):
        """The ColumnLayout of x."""
        return ColumnLayout(self.robot.n, self.uses)

    def link_pull(self, x, load=None):
        """Return link_pull.link_pull (N, n) [Nm], twice; x: EffectInput; load: products (10,)."""
        leans = self.layout.tilt(self.mean).any()
        return link_pull(self.layout, x, self.mean, tilt_along(
            self.robot, self.layout, x.q, self.mean, load) if leans else None)

    def slices(self):
        """Return (EffectUse, slice of x) pairs."""
        return effect_slices(self.robot.n, self.uses)

    def torque(self, q, v, a, temperature=None):
        """
        Return tau_mdl (n,) while sliding steadily, for planning (no path history).

        temperature (n,) [degC] or None for the reference.
        """
        rows = (row if row is None else np.asarray(row)[None] for row in (q, v, a, temperature))
        return self.torques(*rows)[0]

    def torques(self, q, v, a, temperature=None):
        """Return `torque` (N, n) of motions (N, n), each by itself."""
        warmth = np.broadcast_to(self._warmth(temperature), q.shape)
        x = EffectInput(q, v, a, warmth, np.sign(v))
        return torque_columns(self.robot, self.layout, x, self.mean) @ self.mean

    def load_while_sliding(self, q, v, a, temperature, products):
        """
        Return K (n, 10), torque (n,) [Nm]: a load of products (10,) adds K @ products + torque.

        For planning, as `torque` is; in the load frame (eq. 10), through the model's effects. The
        torque is not the load's but of its presence (load_through_effects.py).
        """
        return load_while_sliding(self, (q, v, a), temperature, products)

    def _warmth(self, temperature):
        if temperature is None:
            return np.zeros(self.robot.n)
        return warmth_of(self.robot, np.asarray(temperature, dtype=float))


def drift_std(model, known):
    """
    Return (n, 3): standard deviations of offset, Coulomb level and viscous coefficient.

    known (n,) bool: joints whose temperature is measured; the others may be cold or warm.
    """
    drift, variance = model.residuals.drift.copy(), model.covariance.diagonal()
    for use, columns in model.slices():
        if use.name in WARMED and not known[use.joint]:
            k = columns.start
            slope = np.hypot(model.mean[k], np.sqrt(variance[k]))
            where = use.joint, WARMED[use.name]
            drift[where] = np.hypot(drift[where], slope * UNKNOWN_WARMTH)
    return drift


def nuisance_columns(columns, uncertain, drift, z, v):
    """
    Return (N, n, r + 3 n): torque of the model's unit-variance uncertainties.

    columns Y (N, n, P); uncertain (P, r); drift (n, 3); z, v (N, n) of the columns.
    """
    count, n = z.shape
    known, places = uncertain.shape[1], np.arange(DRIFTS * n)
    out = np.zeros((count, n, known + DRIFTS * n))
    out[:, :, :known] = columns @ uncertain
    basis = np.empty((count, DRIFTS, n))
    basis[:, 0], basis[:, 1], basis[:, 2] = 1.0, z, v
    basis *= drift.T
    out[:, places % n, known + places] = basis.reshape(count, -1)
    return out


def uncertain_directions(model, directions, seed):
    """
    Return (P, r): the directions of x whose uncertainty moves the torque most, scaled to one std.

    The covariance holds many directions that no torque shows (base parameters); over random
    motions inside the limits the few that matter are the leading singular vectors.
    """
    if not np.any(model.covariance):
        return np.zeros((len(model.mean), 0))
    robot, rng = model.robot, np.random.default_rng(seed)
    count, n = 400, robot.n
    limits = robot.limits
    q = rng.uniform(np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi), (count, n))
    v = rng.uniform(-0.7, 0.7, (count, n)) * limits.velocity
    a = rng.uniform(-0.5, 0.5, (count, n)) * limits.acceleration
    x = EffectInput(q, v, a, rng.uniform(-10.0, 25.0, (count, n)), np.sign(v))
    values, vectors = np.linalg.eigh(model.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    weight = 1.0 / np.sqrt(model.residuals.intensity)
    columns = torque_columns(robot, model.layout, x, model.mean)
    if model.layout.late.size:
        _write_delays(model, x, columns)
    effect = columns @ root
    rows = (effect * weight[None, :, None]).reshape(count * n, -1)
    _, axes = np.linalg.eigh(rows.T @ rows)
    return root @ axes[:, ::-1][:, :directions]


def _write_delays(model, x, columns):
    """
    Write what the shares of delays do at single states x into their columns (N, n, P).

    A state by itself has no past: the torque a shift earlier is that of a motion that led to it,
    to first order, without a reversal.
    """
    layout, now = model.layout, model.layout.prompt_torque(columns, model.mean)
    for use, where in model.slices():
        if use.name == LATE:
            shift = use.shape['shift']
            earlier = replace(x, q=x.q - shift * x.v, v=x.v - shift * x.a)
            then = layout.prompt_torque(
                torque_columns(model.robot, layout, earlier, model.mean), model.mean)
            columns[:, use.joint, where.start] = (then - now)[:, use.joint]
