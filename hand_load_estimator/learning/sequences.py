"""
Make one training sequence: what the estimator would see of a load it does not know.

A true arm is drawn around the *identified* torque model (its covariance, its drift between
recordings, priors for unmodelled torque), moved along a random motion with a random load, and
seen through the estimator's own filter and torque model. Only differences matter, because the
model is linear: tau_real - tau_mdl = K m + Y (x_true - x) + what the model lacks + noise. What
misreads weights has columns as with the true load: the estimator has them with its own.

Before that the same arm makes another motion without a load, which tells the share of the stated
variances its estimates suffer from (load_agreement.py). It is told by two windows, where
identification takes the largest mean of many, so the network must not trust it to a hair.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..course import SHARES
from ..effects import EffectInput
from ..identification.load_agreement import share_of, slices_of, Window, WINDOWS
from ..motion import BANDWIDTH, filter_step
from ..torque.columns import torque_columns
from ..torque.misread_weight import misread_columns
from ..torque.presliding import stuck_density
from ..torque.shown_along import followed_together, SeenCourse, shown_as_one, ShownPart
from ..torque.start_doubt import rests_along, start_doubt_along
from ..torque_model import drift_std, nuisance_columns, uncertain_directions
from .random_loads import random_load
from .random_motions import random_motion, random_waves
from .unmodelled import (coloured_noise, disturbances, draw_friction, friction_state,
                         friction_torque)

# Figures of a Stribeck peak that draws do not have.
PLAIN = frozenset({'travel', 'plastic', 'velocity_range'})
RATE = 100.0      # [Hz] of the simulated messages
EVERY = 2         # messages per step of the estimator
DURATION = 10.0   # [s]
VELOCITY_NOISE = (1e-4, 3e-3)   # [rad/s] at RATE: what drivers report differs that much
NOISE_BANDWIDTH = BANDWIDTH * 3.0 / 16.0        # [Hz] two-sided, of the estimator's filter
# Identification states what it found on data left out, colder or warmer than the rest: mostly
# more than a run shows, each joint by its own. Powers of ten by which stated densities exceed
# actual ones (simulated development arms: 1.1 to 1.5 times in the median of a joint).
OVERSTATED = (-0.1, 0.5)
SLOW_MEMORY = 0.5                               # [s] typical of slow residuals


@dataclass(frozen=True)
class Sequence:
    """
    One sequence of N steps for an arm of n joints and d = 10 + r unknowns.

    motion (N, 3, n): q, v, a; difference (N, n) [Nm]; columns (N, n, d); warmth (N, n) [K],
    NaN without a sensor; z, doubt (N, n); load: message order (10,); begin: index of motion
    start; density (N, n) [Nm^2 s] as ModelFollower states it; level, rmse (n,) [Nm],
    intensity (n,) [Nm^2 s]: friction level and residual of the model in use; severe: whether an
    undeclared effect stands out.
    """

    motion: np.ndarray
    difference: np.ndarray
    columns: np.ndarray
    warmth: np.ndarray
    z: np.ndarray
    doubt: np.ndarray
    load: np.ndarray
    begin: np.ndarray
    density: np.ndarray
    level: np.ndarray
    rmse: np.ndarray
    intensity: np.ndarray
    severe: np.ndarray


class SequenceMaker:
    """Make Sequences around one identified TorqueModel, each from its own seed."""

    def __init__(self, model, directions=12):
        self._model = model
        self._uncertain = uncertain_directions(model, directions, 0)
        values, vectors = np.linalg.eigh(model.covariance)
        self._root = vectors * np.sqrt(np.maximum(values, 0.0))

    @property
    def model(self):
        """The TorqueModel that arms are drawn around."""
        return self._model

    def make(self, seed):
        """Return the Sequence of a seed."""
        rng = np.random.default_rng(seed)
        model, actual = _vary(rng, self._model)
        robot, times = model.robot, np.arange(int(DURATION * RATE)) / RATE
        q, v, a, course, torque = _seen(rng, model, actual, (
            random_waves(rng, robot, times), random_motion(rng, robot, times)))
        warmth, measured = _warmths(rng, model, len(q))
        dt = np.full(len(q), EVERY / RATE)
        x, doubt = _inputs(model, (q, v, a), course, np.nan_to_num(measured), dt)
        z = x.z
        columns = torque_columns(robot, model.layout, x, model.mean, dt)
        load_columns = robot.load_columns(columns[:, :, :10 * robot.n])
        error = torque - _sliding_friction(model, x, columns) \
            + _temperature_error(model, x, columns, warmth)
        error += self._model_error(rng, actual, columns, x)
        load = random_load(rng, robot)
        misread = 1.0 + robot.effort.torque_constants_std * rng.normal(size=robot.n)
        before, late = slice(len(q) // 2), slice(len(q) // 2, None)
        carried = load_columns @ load.to_products()
        carried[before] = 0.0
        held = misread * carried
        undeclared, severe = disturbances(rng, q, v, columns @ model.mean + error + held,
                                          np.sqrt(actual.intensity / (2.0 * SLOW_MEMORY)),
                                          EVERY / RATE)
        if severe:
            # What stands out came after identification.
            undeclared[before] = 0.0
        difference = error + held + undeclared
        nuisances = nuisance_columns(columns, self._uncertain,
                                     drift_std(model, np.isfinite(measured[0])), z, v)
        level, intensity = model.friction_level(), model.residuals.intensity
        stuck = stuck_density(z, doubt, v, level)
        share = _share(Window(*(part[before] for part in (
            load_columns, nuisances, difference, dt[:, None] / (intensity + stuck)))), dt[before])
        moving = np.flatnonzero((np.abs(v[late]) > 0.05).any(axis=1))
        return _as_float32(Sequence(
            motion=np.stack([q, v, a], axis=1)[late], difference=difference[late],
            columns=np.concatenate([
                load_columns[late], _misread(model, x, columns, carried, load, late),
                np.sqrt(share) * nuisances[late]], axis=2),
            warmth=measured[late], z=z[late], doubt=doubt[late], load=load.to_message(),
            begin=np.array(moving[0] if len(moving) else len(q) // 2 - 1),
            density=share * (intensity + stuck[late]), level=level, rmse=model.residuals.rmse,
            intensity=share * intensity, severe=np.array(severe)))

    def _model_error(self, rng, actual, columns, x):
        """Return torque (N, n) of identified parameters that are off as their covariance says."""
        error = columns @ (self._root @ rng.normal(size=self._root.shape[1]))
        drift = nuisance_columns(columns, self._uncertain[:, :0], actual.drift, x.z, x.v)
        return error + drift @ rng.normal(size=drift.shape[2])


def _misread(model, x, columns, carried, load, rows):
    """Return misread_columns of rows (a slice), as with a load whose torque is carried (N, n)."""
    links, held = 10 * model.robot.n, load.to_products()
    gear = columns[:, :, :links] @ model.mean[:links] + carried + model.link_pull(x)[0]
    torque = columns @ model.mean + carried
    return np.array([misread_columns(model, *state, held)
                     for state in zip(*(part[rows] for part in (x.q, x.z, gear, torque)))])


def _as_float32(sequence):
    return Sequence(**{name: np.asarray(value, dtype=np.float32)
                       for name, value in vars(sequence).items()})


def _share(run, dt):
    """Return the share of the stated variances by which a run (Window) without load errs."""
    return share_of([Window(*(part[rows] for part in vars(run).values())).squared_error()
                     for rows in slices_of(dt, np.zeros(len(dt), dtype=int), WINDOWS[0])])


def _seen(rng, model, actual, motions):
    """
    Return q, v, a, course (N, 2, STEPS, n) and torque of friction and noise, through the filter.

    Of several motions (q, v, a) of the same arm, one after the other; (N, n) each.
    """
    count = len(motions[0][0])
    q, v = (np.concatenate([motion[k] for motion in motions]) for k in (0, 1))
    torque = _friction_and_noise(rng, model, actual, q, v)
    v = v + np.exp(rng.uniform(*np.log(VELOCITY_NOISE))) * rng.normal(size=v.shape)
    parts = []
    for first in range(0, len(q), count):
        rows = slice(first, first + count)
        *motion, filtered = _through_filter(q[rows], v[rows], torque[rows])
        parts.append((*motion, _course(q[rows], v[rows], len(filtered)), filtered))
    return tuple(np.concatenate(part) for part in zip(*parts))


def _course(q, v, count):
    """Return the course (count, 2, STEPS, n) of messages q, v (N, n), as MeasuredCourse has it."""
    at = (EVERY * np.arange(count)[:, None] - 1 + EVERY * SHARES).clip(0.0)
    before = np.minimum(at.astype(int), len(q) - 2)
    share = (at - before)[..., None]
    return np.stack([part[before] + share * (part[before + 1] - part[before])
                     for part in (q, v)], axis=1)


def _remembered(shown):
    """Return a ShownAlong that does nothing twice."""
    known = {}

    def at(*places):
        key = tuple(np.asarray(place).tobytes() for place in places)
        if key not in known:
            known[key] = shown(*places)
        return known[key]
    return at


def _inputs(model, motion, course, warmth, dt):
    """Return (EffectInput, doubt (N, n)) along both motions; warmth (N, n) [K], dt (N,) [s]."""
    n, half = model.robot.n, len(dt) // 2
    own = model.presliding_distance(), model.presliding_plastic()
    level = model.contact_level()
    # Friction is drawn at the reference temperature (_friction_and_noise).
    level = level and replace(level, slope=np.zeros(n))
    parts = tuple(ShownPart(SeenCourse(course[rows], dt[rows], np.full(half, EVERY)), warmth[rows],
                            level) for rows in (slice(half), slice(half, None)))
    shown = shown_as_one(next(followed_together(parts, [own])))
    x = EffectInput(*motion, warmth, shown.z, shown=_remembered(shown),
                    at_once=np.concatenate([part.seen.at_once for part in parts]))
    q, v = (part.reshape(2, half, n) for part in motion[:2])
    return x, np.concatenate([
        start_doubt_along(seen.ways, rests_along(*each, seen.dt), seen.dt, own[0])
        for seen, *each in zip((part.seen for part in parts), q, v)])


def _vary(rng, model):
    """
    Return a model of another arm of the kind, and the Residuals it really has.

    Friction levels and noise are somewhat different; the model's own figures overstate them.
    """
    n = model.robot.n
    mean = model.mean.copy()
    size = np.exp(rng.normal(0.0, 0.15, n))
    travel = np.exp(rng.normal(0.0, 0.3, n))
    uses = []
    for use, where in model.slices():
        if use.name != 'torque_offset':
            mean[where] *= size[use.joint]
        shape = {name: np.inf if name in PLAIN and use.name == 'stribeck_friction' else value
                 for name, value in use.shape.items()}
        if 'presliding_distance' in shape:
            shape['presliding_distance'] *= travel[use.joint]
        uses.append(replace(use, shape=shape))
    old, excess = model.residuals, 10.0 ** rng.uniform(*OVERSTATED, n)
    noisier = np.exp(rng.normal(0.0, 0.2, n))
    actual = replace(old, rmse=old.rmse * noisier * excess ** -0.2,
                     intensity=old.intensity * noisier ** 2 / excess,
                     drift=old.drift * (noisier * excess ** -0.5)[:, None])
    return replace(model, mean=mean, uses=tuple(uses)), actual


def _warmths(rng, model, count):
    """Return true and measured (count, n) temperatures above the reference [K]."""
    n, reference = model.robot.n, model.robot.reference_temperature
    low, high = model.temperatures or (15.0, 50.0)
    start = rng.uniform(low - 3.0, high + 3.0) - reference
    true = start + rng.normal(0.0, 2.0, n) + np.outer(
        np.linspace(0.0, 1.0, count), np.abs(rng.normal(0.0, 0.5, n)))
    measured = true + rng.normal(0.0, 0.4, n)
    if model.temperatures is None or rng.random() < 0.05:
        measured = np.full_like(true, np.nan)
    return true, measured


def _values(model, name, k=0, shape=None):
    """Return a parameter (or shape value) of an effect for all joints (n,)."""
    out = np.zeros(model.robot.n) if shape is None else np.full(model.robot.n, 0.1)
    for use, where in model.slices():
        if use.name == name:
            out[use.joint] = use.shape[shape] if shape else model.mean[where.start + k]
    return out


def _friction_and_noise(rng, model, actual, q, v):
    """Return torque (N, n): true friction at the reference temperature, and noise."""
    truth = draw_friction(
        rng, _values(model, 'coulomb_friction'), _values(model, 'stribeck_friction'),
        _values(model, 'presliding_hysteresis'), _values(model, 'viscous_friction'),
        [_values(model, 'stribeck_friction', shape=figure)
         for figure in ('stribeck_velocity', 'exponent')],
        (model.presliding_distance(), model.presliding_plastic()))
    friction = friction_torque(friction_state(rng, q, v, 1.0 / RATE, truth), v, truth)
    white = rng.uniform(0.3, 1.0, model.robot.n) * np.minimum(
        actual.rmse ** 2 / NOISE_BANDWIDTH, actual.intensity)
    # The measured density is the largest over block lengths and holds what disturbances add.
    slow = rng.uniform(0.1, 0.7, model.robot.n) * actual.intensity
    noise = rng.normal(size=q.shape) * np.sqrt(white * RATE)
    return friction + noise + coloured_noise(rng, len(q), slow, 1.0 / RATE)


def _sliding_friction(model, x, columns):
    """Return (N, n): what the model subtracts for the friction that draw_friction varies."""
    mean = np.zeros(len(model.mean))
    for use, where in model.slices():
        if use.name in ('coulomb_friction', 'stribeck_friction', 'viscous_friction',
                        'presliding_hysteresis'):
            mean[where] = model.mean[where]
    return _columns_at(model, x, columns, np.zeros_like(x.warmth)) @ mean


def _temperature_error(model, x, columns, warmth):
    """Return (N, n): effects at the true warmth less effects at the measured one."""
    return (_columns_at(model, x, columns, warmth) - columns) @ model.mean


def _columns_at(model, x, columns, warmth):
    """
    Return columns Y (N, n, P) of an EffectInput as they are at another warmth (N, n) [K].

    But for a Stribeck peak's velocity, which stays as it was.
    """
    out = columns.copy()
    model.layout.fill(out, replace(x, warmth=warmth))
    return out


def _through_filter(q, v, torque):
    """
    Return filtered q, v, a, torque (N / EVERY, n) as MotionFilter gives them without Derivatives.

    Accelerations by the velocity alone are what an arm with a coarse encoder has.
    """
    matrix, before, now = filter_step(1.0 / RATE)
    signal = np.concatenate([q, v, torque], axis=1)
    state = np.repeat(signal[:1], 3, axis=0)
    n, out = q.shape[1], []
    for k in range(1, len(signal)):
        state = matrix @ state + np.outer(before, signal[k - 1]) + np.outer(now, signal[k])
        if k % EVERY == EVERY - 1:
            rate = BANDWIDTH * (state[1, n:2 * n] - state[2, n:2 * n])
            out.append((state[2, :n], state[2, n:2 * n], rate, state[2, 2 * n:]))
    return tuple(np.array(column) for column in zip(*out))
