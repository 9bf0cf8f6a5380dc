"""
Identify a torque model from recordings without load, or with a known one (eq. 11).

Weighted regularised least squares around the nominal parameters:
x = x_nom + (sum Y^T W Y + P0^-1)^-1 sum Y^T W (tau - Y x_nom), where P0 says how far nominal link
data may be off and how large an effect may be, and W is the inverse spectral density of the
residual, so that coloured residuals do not pass for knowledge.
"""

from copy import copy
from dataclasses import dataclass, field, replace

import numpy as np

from .effects import DEFAULT_EFFECTS, EFFECTS, NEEDS_TEMPERATURE
from .errors import ConfigurationError, RecordingError
from .knee_fit import with_knees_fitted
from .load import LoadParameters
from .load_agreement import LeftOut, share_left_out
from .presliding import stuck_density
from .sliding import sliding_rms, surely_slides
from .torque_columns import (as_reported, ColumnLayout, EffectUse, effect_columns, effect_slices,
                             motion_input, parameter_count, presliding_distances, real_torque,
                             torque_columns)
from .torque_model import Residuals, TorqueModel

# How far a link's published mass, and its first and second moments, may be off.
LINK_DOUBT = 0.1
# Lengths [s] of the block means from which the residual's density is read.
BLOCK_MEANS = (0.06, 0.2, 0.5, 1.0)
# Smallest residual believed, as a fraction of the joint's maximum torque.
LEAST_NOISE = 1e-4
# Below this much usable motion [s] there is nothing to identify from.
LEAST_MOTION = 3.0


@dataclass(frozen=True)
class Evidence:
    """
    One recording made ready, or a part of it: name of the recording, Motion, torque less the known
    load's (N, n) [Nm].

    held (N, n) [Nm]: the known load's torque, which drives and gears carry all the same, or None;
    load: LoadParameters declared.
    """

    name: str
    motion: object
    torque: np.ndarray
    held: np.ndarray | None = None
    load: LoadParameters = field(default_factory=LoadParameters)


def recording_numbers(evidence):
    """Return for each Evidence the number of its recording: parts of one have its name."""
    names = list(dict.fromkeys(e.name for e in evidence))
    return [names.index(e.name) for e in evidence]


def prepare(robot, name, motion, load):
    """Return the Evidence of a Motion recorded with the given LoadParameters."""
    if len(motion.stamp) == 0:
        raise RecordingError(f'{name}: holds no usable joint states')
    torque = np.array([real_torque(robot, q, e) for q, e in zip(motion.q, motion.effort)])
    if load.mass == 0.0:
        return Evidence(name, motion, torque)
    products = load.to_products()
    held = np.array([robot.load_regressor(q, v, a) @ products
                     for q, v, a in zip(motion.q, motion.v, motion.a)])
    return Evidence(name, motion, torque - held, held, load)


def prior(robot, uses, links_declared):
    """Return the nominal x (P,) and its covariance P0 (P, P, diagonal)."""
    n = robot.n
    mean = np.zeros(parameter_count(n, uses))
    mean[:10 * n] = robot.nominal_links
    std = np.zeros_like(mean)
    if links_declared:
        for j in range(n):
            m, first = mean[10 * j], mean[10 * j + 1:10 * j + 4]
            reach = np.linalg.norm(first) / max(m, 1e-9) + 0.05
            std[10 * j] = LINK_DOUBT * m
            std[10 * j + 1:10 * j + 4] = LINK_DOUBT * m * reach
            std[10 * j + 4:10 * j + 10] = LINK_DOUBT * m * reach ** 2
        # A massless link would fix its own parameters; let it be as doubtful as a small one.
        std[:10 * n] = np.maximum(std[:10 * n], 1e-5)
    for use, where in effect_slices(n, uses):
        std[where] = use.effect.std(robot.limits.torque[use.joint])
    return mean, np.diag(std ** 2)


def declare(robot, names, temperatures_known):
    """Return (uses, links_declared) for effect names; all joints, default shapes."""
    names = DEFAULT_EFFECTS if names is None else names
    known = ('link_inertia', *EFFECTS)
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ConfigurationError('--effects', 'names unknown effects', ', '.join(unknown),
                                 ', '.join(known))
    chosen = [EFFECTS[name] for name in names if name in EFFECTS]
    searched = [e.name for e in chosen if any(not s.grid for s in e.shapes)]
    if searched:
        raise ConfigurationError('--effects', 'names effects whose shape only a residual tells',
                                 ', '.join(searched), todo='find them with `hand_load diagnose`')
    if robot.effort.kind == 'link_torque' and names is DEFAULT_EFFECTS:
        chosen = [e for e in chosen if e.in_link_torque]
    if not temperatures_known:
        chosen = [e for e in chosen if e.name not in NEEDS_TEMPERATURE]
    uses = tuple(EffectUse(e.name, j, e.default_shape())
                 for j in range(robot.n) for e in chosen if not (e.whole_arm and j))
    return uses, 'link_inertia' in names


class System:
    """
    Columns, torque and friction doubt of several recordings for one set of effects.

    mean (P,): parameters that tell torques to the effects that depend on them.
    """

    def __init__(self, robot, uses, evidence, mean):
        self.robot, distance = robot, presliding_distances(robot.n, uses)
        layout = ColumnLayout(robot.n, uses)
        inputs = [motion_input(robot, e.motion, distance) for e in evidence]
        self._inputs = [x for x, _ in inputs]
        self.columns = np.concatenate([
            torque_columns(robot, layout, x, mean, e.motion.dt, e.held)
            for (x, _), e in zip(inputs, evidence)])
        self.torque = np.concatenate([e.torque for e in evidence])
        self.doubt = np.concatenate([doubt for _, doubt in inputs])
        self.dt = np.concatenate([e.motion.dt for e in evidence])
        self.owner = np.concatenate([np.full(len(e.torque), k) for k, e in enumerate(evidence)])
        self.recording = np.concatenate([
            np.full(len(e.torque), k) for k, e in zip(recording_numbers(evidence), evidence)])
        self.velocity = np.concatenate([x.v for x, _ in inputs])
        self.z = np.concatenate([x.z for x, _ in inputs])
        self._uses = uses

    def columns_of(self, use):
        """Return the columns (N, k) of an effect that reads no torques."""
        return np.concatenate([effect_columns(x, use) for x in self._inputs])

    def reshape(self, use, where):
        """Write the columns of such an effect anew; where: its slice of x."""
        self.columns[:, use.joint, where] = self.columns_of(use)

    def with_more(self, columns):
        """Return a System with columns (N, n, k) behind its own."""
        out = copy(self)
        out.columns = np.concatenate([self.columns, columns], axis=2)
        return out

    def weights(self, intensity, friction):
        """Return (N, n): dt / density, less where the friction state is in doubt."""
        stuck = stuck_density(self.z, self.doubt, self.velocity, friction)
        for k in np.unique(self.owner):
            rows = self.owner == k
            stuck[rows] = as_reported(self._uses, stuck[rows], self.dt[rows])
        return self.dt[:, None] / (intensity + stuck)

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
            weighted = yj * w[:, j, None]
            information[np.ix_(own, own)] += weighted.T @ yj
            gradient[own] += weighted.T @ (tau[:, j] - y[:, j] @ mean)
        return information, gradient

    def residual(self, x):
        """Return tau - Y x, (N, n)."""
        return self.torque - self.columns @ x


def posterior_of(mean, covariance, told):
    """Return posterior mean (P,) and covariance (P, P) of a prior and what data told of it."""
    information, gradient = told
    free = np.flatnonzero(np.diag(covariance) > 0.0)
    # Scaling by the prior keeps masses and inertias of small links in one range.
    scale = np.sqrt(np.diag(covariance)[free])
    scaled = information * np.outer(scale, scale) + np.eye(len(free))
    inverse = np.linalg.inv(scaled)
    posterior = np.zeros_like(covariance)
    posterior[np.ix_(free, free)] = 0.5 * (inverse + inverse.T) * np.outer(scale, scale)
    x = mean.copy()
    x[free] += scale * (inverse @ (scale * gradient))
    return x, posterior


def density(residual, weights, owner, dt):
    """
    Return the residual's low-frequency density (n,) [Nm^2 s] from means over blocks.

    A block's mean has variance density / length when the block is longer than the residual's
    memory, less when it is shorter; the largest product over BLOCK_MEANS is the safe one.
    """
    period = float(np.median(dt))
    best = np.zeros(residual.shape[1])
    for length in BLOCK_MEANS:
        size = max(1, round(length / period))
        count = len(residual) // size
        if count < 8:
            break
        shape = (count, size, residual.shape[1])
        r, w = residual[:count * size].reshape(shape), weights[:count * size].reshape(shape)
        block_owner = owner[:count * size].reshape(count, size)
        whole = (block_owner == block_owner[:, :1]).all(axis=1)
        total = w.sum(axis=1)
        means = (w * r).sum(axis=1) / np.maximum(total, 1e-30)
        good = total * whole[:, None]
        best = np.maximum(best, (good * means ** 2).sum(axis=0)
                          / np.maximum(good.sum(axis=0), 1e-30) * size * period)
    return best


def _search_shapes(robot, uses, evidence, x, intensity, friction):
    """Return uses with each joint's shapes set to the values that fit its residual best."""
    uses = list(uses)
    # The same weights for every trial: a longer presliding travel would excuse more samples.
    weights = System(robot, tuple(uses), evidence, x).weights(intensity, friction)
    for name, shape in _shapes_of(uses):
        best = {}
        for value, trial, system in _trials(robot, uses, evidence, x, name, shape):
            for j, cost in enumerate(_joint_costs(robot, trial, system, x, weights)):
                # Twice the nats that the value must gain over the first, which is the default.
                if j not in best or cost < best[j][0] - 2.0 * _price(shape, best[j][1]):
                    best[j] = (cost, value)
        uses = [replace(u, shape={**u.shape, shape.name: best[u.joint][1]})
                if u.name == name else u for u in uses]
    return tuple(uses)


def _trials(robot, uses, evidence, x, name, shape):
    """Yield (value, uses with it on all joints, their System) for the grid of a Shape."""
    alone = name != 'presliding_hysteresis' and EFFECTS[name].needs <= {'warmth'}
    system = System(robot, tuple(uses), evidence, x) if alone else None
    for value in shape.grid:
        trial = tuple(replace(u, shape={**u.shape, shape.name: value})
                      if u.name == name else u for u in uses)
        if not alone:
            system = System(robot, trial, evidence, x)
        for use, where in effect_slices(robot.n, trial) if alone else ():
            if use.name == name:
                system.reshape(use, where)
        yield value, trial, system


def _price(shape, value):
    """Return the nats that another value of a Shape must gain beyond this one."""
    return shape.gain if value == shape.default else 0.0


def _shapes_of(uses):
    """Return the different (effect name, Shape) pairs, presliding first: it changes z."""
    seen = {(u.name, s.name): (u.name, s) for u in uses for s in u.effect.shapes if s.grid}
    return sorted(seen.values(), key=lambda pair: pair[0] != 'presliding_hysteresis')


def _joint_costs(robot, uses, system, x, weights):
    """Return each joint's weighted squared residual with its own effects refitted."""
    start = 10 * robot.n
    for j in range(robot.n):
        own = [w for u, w in effect_slices(robot.n, uses) if u.joint == j]
        if not own:
            yield 0.0
            continue
        index = np.concatenate([np.arange(w.start, w.stop) for w in own])
        y = system.columns[:, j, :]
        target = system.torque[:, j] - y[:, :start] @ x[:start]
        root = np.sqrt(weights[:, j])
        matrix = y[:, index] * root[:, None]
        scale = np.linalg.norm(matrix, axis=0) + 1e-12
        solution, *_ = np.linalg.lstsq(matrix / scale, target * root, rcond=1e-8)
        yield float(np.sum((target * root - matrix / scale @ solution) ** 2))


def drift_of(system, residual, weights):
    """
    Return the std (n, 3) between recordings of offset, Coulomb level and viscous coefficient.

    Each recording's residual is fitted by the three; the spread over recordings, less what its
    own noise explains, is what changes from day to day. Recordings are halved, so that one alone
    also shows how it changes with time.
    """
    n = residual.shape[1]
    out = np.zeros((n, 3))
    groups = []
    for k in np.unique(system.recording):
        rows = np.flatnonzero(system.recording == k)
        groups += [half for half in np.array_split(rows, 2) if len(half) > 50]
    for j in range(n):
        fits, errors = [], []
        for rows in groups:
            moving = rows[np.abs(system.velocity[rows, j]) > 0.02]
            if len(moving) < 50:
                continue
            y = np.stack([np.ones(len(moving)), system.z[moving, j],
                          system.velocity[moving, j]], axis=1)
            w = weights[moving, j]
            covariance = np.linalg.inv((y * w[:, None]).T @ y + 1e-9 * np.eye(3))
            fits.append(covariance @ ((y * w[:, None]).T @ residual[moving, j]))
            errors.append(np.diag(covariance))
        if fits:
            # Moment estimate of a random effect around zero, each fit weighed by its precision;
            # a quarter of the fits' own error stays as what this many fits cannot exclude.
            precision = 1.0 / np.array(errors)
            total = precision.sum(axis=0)
            excess = ((np.square(fits) * precision).sum(axis=0) - len(fits)) / total
            out[j] = np.sqrt(np.maximum(excess, 0.25 * len(fits) / total))
    return out


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


def identify(robot, evidence, effects=None, progress=lambda text: None):
    """
    Return the TorqueModel identified from a list of Evidence.

    effects: names to declare, or None for the default list. Raises ConfigurationError for
    unknown effects and RecordingError when the recordings hold too little motion.
    """
    temperatures = np.concatenate([e.motion.temperature.ravel() for e in evidence])
    known = np.isfinite(temperatures).any()
    uses, links_declared = declare(robot, effects, known)
    _require_motion(evidence)
    mean, covariance = prior(robot, uses, links_declared)
    intensity = (0.01 * robot.limits.torque) ** 2 * 0.02
    friction = 0.03 * robot.limits.torque
    x = mean
    for turn in range(4):
        progress(f'identification pass {turn + 1} of 4')
        if turn in (1, 2):
            uses = _search_shapes(robot, uses, evidence, x, intensity, friction)
        system = System(robot, uses, evidence, x)
        weights = system.weights(intensity, friction)
        x, posterior = system.solve(mean, covariance, weights)
        intensity = density(system.residual(x), weights, system.owner, system.dt)
        friction = TorqueModel(robot, uses, links_declared, x, posterior, None).friction_level()
    searched = uses
    uses, _, _ = with_knees_fitted(system, uses, searched, mean, covariance, weights)
    left_out = held_out(system, mean, covariance, weights)
    intensity = density(left_out.residual, weights, system.owner, system.dt)
    stated = system.weights(intensity, friction)
    uses, x, posterior = with_knees_fitted(system, uses, searched, mean, covariance, stated)
    drift = drift_of(system, left_out.residual, weights)
    sliding = sliding_rms(left_out.residual,
                          surely_slides(system.velocity, system.z, system.doubt), system.dt,
                          system.owner)
    residuals = Residuals(rmse_of(robot, system, left_out.residual), intensity, drift,
                          sliding, share_left_out(system, left_out, stated, drift))
    seen = temperatures[np.isfinite(temperatures)]
    return TorqueModel(robot, uses, links_declared, x, posterior, residuals,
                       tuple(e.name for e in evidence),
                       (float(seen.min()), float(seen.max())) if known else None)


def rmse_of(robot, system, residual):
    """Return the RMS (n,) [Nm] of a residual (N, n) of a System while joints surely slide."""
    moving = (system.doubt < 0.1) & (np.abs(system.z) > 0.9)
    rmse = np.sqrt((moving * residual ** 2).sum(axis=0) / np.maximum(moving.sum(axis=0), 1))
    # A joint that never slid shows no noise; it has some.
    return np.maximum(rmse, LEAST_NOISE * robot.limits.torque)


def _require_motion(evidence):
    moving = sum(float(e.motion.dt[np.abs(e.motion.v).max(axis=1) > 0.02].sum())
                 for e in evidence)
    if moving < LEAST_MOTION:
        raise RecordingError(
            f'{", ".join(e.name for e in evidence)}: hold {moving:.1f} s of motion; at least '
            f'{LEAST_MOTION:g} s are needed; record a motion of `hand_load excite`')


def nominal_model(robot, noise_intensity):
    """Return the robot file's own model: nominal links, no effects (a baseline's model)."""
    mean, _ = prior(robot, (), False)
    residuals = Residuals(np.sqrt(noise_intensity / 0.02), np.asarray(noise_intensity),
                          np.zeros((robot.n, 3)))
    return TorqueModel(robot, (), False, mean, np.zeros((len(mean), len(mean))), residuals)


