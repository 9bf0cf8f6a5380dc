"""
The torque model: rigid body + declared effects, all linear in one parameter vector.

tau_mdl = Y(theta, theta', theta'') x, where x holds the links' products (10 n) followed by the
effects' parameters, joint by joint. The same columns serve identification (eq. 11), prediction
(E1.1) and the model's own uncertainty at run time.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from .effects import EFFECTS, EffectInput
from .late_load import LateLoad
from .load import products_from_message
from .play import PlayState, play_along
from .presliding import STUCK_TIME, PreslidingState, presliding_path, stuck_variance
from .robot import Robot
from .torque_noise import SampleNoise

# Offset, Coulomb level and viscous coefficient of each joint drift from run to run.
DRIFTS = 3
# Used for joints whose model declares no presliding: friction turns within encoder resolution.
NO_PRESLIDING = 1e-4


@dataclass(frozen=True)
class EffectUse:
    """
    One declared effect on one joint: its name, joint index and shape values.

    An effect of the whole arm stands at joint 0.
    """

    name: str
    joint: int
    shape: dict = field(default_factory=dict)

    @property
    def effect(self):
        """The Effect of that name."""
        return EFFECTS[self.name]


@dataclass(frozen=True)
class Residuals:
    """
    What the model does not explain, per joint (n,).

    rmse [Nm]: of the filtered torque on held-out data. intensity [Nm^2 s]: spectral density of
    the residual at low frequencies; over t seconds an average of it has variance intensity / t,
    which is what coloured residuals do to an estimate. drift (n, 3) [Nm, Nm, Nm s/rad]: standard
    deviation between recordings of offset, Coulomb level and viscous coefficient.
    """

    rmse: np.ndarray
    intensity: np.ndarray
    drift: np.ndarray


@dataclass(frozen=True)
class TorqueModel:
    """
    An identified (or nominal) torque model of one robot.

    uses: EffectUse in the order of their columns; links_declared: whether the links' products
    were identified; mean (P,), covariance (P, P) of x; residuals; recordings it came from;
    temperatures: (low, high) [degC] seen, or None.
    """

    robot: Robot
    uses: tuple
    links_declared: bool
    mean: np.ndarray
    covariance: np.ndarray
    residuals: Residuals
    recordings: tuple = ()
    temperatures: tuple | None = None

    @property
    def noise(self):
        """RMS (n,) [Nm] of the torque the model leaves unexplained."""
        return self.residuals.rmse

    def presliding_distance(self):
        """Return the travel (n,) [rad] over which each joint's friction turns."""
        return presliding_distances(self.robot.n, self.uses)

    def friction_level(self):
        """Return the largest sliding friction (n,) [Nm] at low speed, reference temperature."""
        coulomb, stribeck = np.zeros(self.robot.n), np.zeros(self.robot.n)
        for use, columns in self.slices():
            if use.name == 'coulomb_friction':
                coulomb[use.joint] = self.mean[columns.start]
            elif use.name == 'stribeck_friction':
                stribeck[use.joint] = self.mean[columns.start]
        return np.maximum(np.abs(coulomb), np.abs(coulomb + stribeck))

    @cached_property
    def layout(self):
        """The ColumnLayout of x."""
        return ColumnLayout(self.robot.n, self.uses)

    def slices(self):
        """Return (EffectUse, slice of x) pairs."""
        return effect_slices(self.robot.n, self.uses)

    def torque(self, q, v, a, temperature=None):
        """
        Return tau_mdl (n,) while sliding steadily, for planning (no path history).

        temperature (n,) [degC] or None for the reference.
        """
        sign = np.sign(v)
        warmth = self._warmth(temperature)
        x = EffectInput(*(s[None] for s in (q, v, a, warmth, sign)))
        return torque_columns(self.robot, self.layout, x, self.mean)[0] @ self.mean

    def load_regressor(self, q, v, a):
        """Return K (n, 10) in the load frame (eq. 10)."""
        return self.robot.load_regressor(q, v, a)

    def _warmth(self, temperature):
        if temperature is None:
            return np.zeros(self.robot.n)
        return warmth_of(self.robot, np.asarray(temperature, dtype=float))


def warmth_of(robot, temperature):
    """Return temperature less reference [K], 0 where it is NaN."""
    return np.nan_to_num(temperature - robot.reference_temperature)


def effect_slices(n, uses):
    """Return (EffectUse, slice of x) pairs for the layout of `uses` behind n links."""
    start, pairs = 10 * n, []
    for use in uses:
        stop = start + len(use.effect.parameters)
        pairs.append((use, slice(start, stop)))
        start = stop
    return pairs


def parameter_count(n, uses):
    """Return P, the length of x."""
    return 10 * n + sum(len(use.effect.parameters) for use in uses)


def presliding_distances(n, uses):
    """Return the presliding travel (n,) [rad] of the joints."""
    distance = np.full(n, NO_PRESLIDING)
    for use in uses:
        if use.name == 'presliding_hysteresis':
            distance[use.joint] = use.shape['presliding_distance']
    return distance


def effect_columns(x, use):
    """Return the columns (N, k) of one effect on its joint."""
    return use.effect.columns(x, use.joint, use.shape)


class ColumnLayout:
    """
    Where the columns of declared effects stand in Y, joints of one effect taken together.

    size: P, the length of x. needs: what the columns read beside motion and friction state.
    """

    def __init__(self, n, uses):
        self.size, self.links = parameter_count(n, uses), 10 * n
        pairs = effect_slices(n, uses)
        self._plain, self._torque_bound = [], []
        for name in dict.fromkeys(use.name for use in uses):
            effect = EFFECTS[name]
            own = [(use, where) for use, where in pairs if use.name == name]
            joints = np.array([use.joint for use, _ in own])
            shape = {s: np.array([use.shape[s] for use, _ in own]) for s in own[0][0].shape}
            places = np.array([range(where.start, where.stop) for _, where in own])
            if effect.whole_arm:
                joints = np.arange(n)
            group = effect, joints, shape, places
            (self._torque_bound if effect.needs & _TORQUES else self._plain).append(group)
        self.needs = frozenset().union(*(EFFECTS[use.name].needs for use in uses)) & _TORQUES

    def fill(self, columns, x):
        """Write the effects that motion and friction state suffice for into columns (N, n, P)."""
        _fill(self._plain, columns, x)

    def fill_torque_bound(self, columns, x):
        """Write the effects that depend on torques into columns (N, n, P)."""
        _fill(self._torque_bound, columns, x)


    def plain_torque(self, columns, mean):
        """Return torque (N, n) [Nm] without the effects that depend on torques themselves."""
        bound = np.zeros(self.size, dtype=bool)
        for *_, places in self._torque_bound:
            bound[places.ravel()] = True
        return columns @ np.where(bound, 0.0, mean)


# Inputs of effects that follow from the other columns.
_TORQUES = frozenset({'gear', 'drive', 'rate', 'tilt', 'late', 'play'})


def _fill(groups, columns, x):
    for effect, joints, shape, places in groups:
        columns[:, joints[:, None], places] = effect.columns(x, joints, shape)


def torque_columns(robot, layout, x, mean=None, dt=None, held=None, before=None,
                   teeth=(None, 0.0)):
    """
    Return Y (N, n, P) for a ColumnLayout and an EffectInput.

    Only for layouts with effects that depend on torques: mean (P,) tells them; dt (N,) [s]
    between the samples, without which torques stand still; held (N, n) [Nm]: torque of a known
    load, which the drives and gears carry too; before: (torque (M, n) [Nm], dt (M,) [s]):
    what `plain_torque` was at the samples before the first; teeth: (PlayState (n) of the gears
    there, carried on; torque (n,) [Nm] that a load which is believed to be held adds).
    """
    count, n = x.q.shape
    columns = np.zeros((count, n, layout.size))
    for k in range(count):
        columns[k, :, :10 * n] = robot.link_regressor(x.q[k], x.v[k], x.a[k])
    layout.fill(columns, x)
    if layout.needs:
        held = 0.0 if held is None else held
        plain = columns @ mean + held
        gear = columns[:, :, :layout.links] @ mean[:layout.links] + held
        layout.fill_torque_bound(columns, replace(
            x, gear=gear, drive=plain, rate=_rate(plain, dt, before),
            late=lateness(plain, dt, before),
            play=play_columns(robot, x.q, gear, dt, teeth) if 'play' in layout.needs else None,
            tilt=tilt_columns(robot, x.q, mean) if 'tilt' in layout.needs else None))
    return columns


def _rate(torque, dt, before):
    """Return the backward difference (N, n) [Nm/s], as a causal estimator has it."""
    if dt is None:
        return np.zeros_like(torque)
    first = torque[:1] if before is None else before[0][-1:]
    return np.diff(torque, axis=0, prepend=first) / dt[:, None]


def lateness(torque, dt, before=None):
    """
    Return late(delays): torque (N, n) [Nm] some seconds ago less the torque now.

    torque (N, n) at samples dt (N,) [s] apart; before: (torque (M, n), dt (M,)) ahead of them.
    """
    if dt is None:
        return lambda delays: np.zeros_like(torque)
    past, gaps = (torque[:0], np.zeros(0)) if before is None else before
    series = np.concatenate([past, torque])
    gaps = np.concatenate([gaps, dt])
    time = np.cumsum(gaps)

    def late(delays):
        delays = np.broadcast_to(delays, series.shape[1])
        now = time[len(past):]
        return np.stack([np.interp(now - delay, time, column) for delay, column in
                         zip(delays, series.T)], axis=1) - torque
    return late


def play_columns(robot, q, gear, dt, teeth=(None, 0.0)):
    """
    Return play(joints, travels, lags) of EffectInput for torques gear (N, n) [Nm] at q (N, n).

    The links' inertias are the robot file's. teeth: as of torque_columns.
    """
    if dt is None:
        return lambda joints, *_: np.zeros((len(q), *np.shape(joints)))
    inertia = np.array([np.diag(robot.mass_matrix(row)) for row in q])
    states, believed = teeth
    return play_along(gear + believed, inertia, dt, states)


def tilt_columns(robot, q, mean):
    """Return (N, n, 2) [Nm/rad]: torque of turned gravity at positions q (N, n) for x (P,)."""
    return np.array([robot.tilt_regressor(row, mean[:10 * robot.n]) for row in q])


def motion_input(robot, motion, distance):
    """Return (EffectInput, doubt (N, n)) along a Motion."""
    z, doubt = presliding_path(motion.q, motion.v, motion.dt, distance)
    return EffectInput(motion.q, motion.v, motion.a, warmth_of(robot, motion.temperature), z), doubt


def real_torque(robot, q, effort):
    """
    Return tau_real (n,) [Nm] of efforts (n,) as reported (E1.2).

    Current times torque constant; the configured load the controller has already taken off is
    put back, as its gravity torque.
    """
    tau = effort * robot.effort.torque_constants
    configured = robot.effort.configured_load
    if configured is not None:
        zero = np.zeros(robot.n)
        tau = tau + robot.load_regressor(q, zero, zero) @ configured.to_products()
    return tau


@dataclass(frozen=True)
class Prediction:
    """
    The torque model at one MotionSample.

    difference (n,) [Nm] = tau_real - tau_mdl; load_columns K (n, 10); model_columns (n, r): what
    the model's own unit-variance uncertainties do to the torque; z, doubt (n,): friction state
    and how far its start is unknown; stuck (n,) [Nm^2]: variance of that; density (n,) [Nm^2 s]
    of the difference beside the load.
    """

    difference: np.ndarray
    load_columns: np.ndarray
    model_columns: np.ndarray
    z: np.ndarray
    doubt: np.ndarray
    stuck: np.ndarray
    density: np.ndarray


class ModelFollower:
    """Evaluate a TorqueModel along a stream of MotionSamples, keeping the friction's path."""

    def __init__(self, model, directions=12, seed=0):
        self.model = model
        self._path = PreslidingState(model.presliding_distance())
        self._friction = model.friction_level()
        self._uncertain = uncertain_directions(model, directions, seed)
        self._noise = SampleNoise(model.residuals.rmse)
        self._known = self._drift = None
        self._carried = np.zeros(10)
        self._late_load = LateLoad({use.joint: (model.mean[where.start], use.shape['shift'])
                                    for use, where in model.slices() if use.name == 'time_delay'})
        self._forget_torques()

    @property
    def uncertainties(self):
        """Number r of model columns."""
        return self._uncertain.shape[1] + DRIFTS * self.model.robot.n

    def restart(self):
        """Forget the path, as after a gap in the data."""
        self._path.restart()
        self._noise.restart()
        self._forget_torques()

    def _forget_torques(self):
        self._before = None
        self._late_load.restart()
        self._teeth = [PlayState() for _ in self.model.robot.joints]

    def carry(self, belief, method, beside=0.0):
        """
        Take a Method's Belief of the load: its torque too decides when teeth part.

        beside: products (10,) of what is held and not in the belief.
        """
        if 'play' in self.model.layout.needs:
            self._carried = products_from_message(belief.mean) + method.tared + beside

    def _believed(self, x):
        """Return the torque (n,) [Nm] of what is believed to be held."""
        if not self._carried.any():
            return 0.0
        return self.model.load_regressor(x.q[0], x.v[0], x.a[0]) @ self._carried

    def _columns(self, x, dt):
        model = self.model
        if not model.layout.needs:
            return torque_columns(model.robot, model.layout, x)
        columns = torque_columns(model.robot, model.layout, x, model.mean, np.array([dt]),
                                 before=self._before, teeth=(self._teeth, self._believed(x)))
        self._remember(model.layout.plain_torque(columns, model.mean), dt)
        return columns

    def _remember(self, torque, dt):
        """Keep the last torques, as far back as a delay may reach."""
        past, gaps = self._before or (torque[:0], np.zeros(0))
        past, gaps = np.concatenate([past, torque]), np.append(gaps, dt)
        keep = np.cumsum(gaps[::-1])[::-1] < _REMEMBERED + dt
        self._before = past[keep], gaps[keep]

    def update(self, sample):
        """Return the Prediction at a MotionSample."""
        robot = self.model.robot
        z, doubt = self._path.update(sample.q, sample.v, sample.dt)
        x = EffectInput(*(s[None] for s in (
            sample.q, sample.v, sample.a, warmth_of(robot, sample.temperature), z)))
        columns = self._columns(x, sample.dt)
        difference = real_torque(robot, sample.q, sample.effort) - columns[0] @ self.model.mean
        known = np.isfinite(sample.temperature)
        if self._known is None or (known != self._known).any():
            self._known, self._drift = known, drift_std(self.model, known)
        nuisances = nuisance_columns(columns, self._uncertain, self._drift, x)[0]
        stuck = stuck_variance(z, doubt, sample.v, self._friction)
        # Identification measured the residual's density; sampled more rarely it has more.
        noise = self._noise.update(difference, sample.dt, sample.messages)
        density = np.maximum(self.model.residuals.intensity, noise) + 2.0 * STUCK_TIME * stuck
        load = robot.load_columns(columns[0, :, :10 * robot.n])
        if self.model.layout.needs:
            load = load_through_effects(self.model, columns[0], load, sample, z) \
                + self._late_load.change(load, sample.dt)
        return Prediction(difference, load,
                          nuisances, z, doubt, stuck, density)


# Torques kept for effects that look back [s]: the longest delay and a sample more.
_REMEMBERED = 0.15


def load_through_effects(model, columns, load, sample, z):
    """
    Return K (n, 10) of a load as effects that depend on torques let it through.

    columns Y (n, P), load K (n, 10) and friction state z (n,) at a MotionSample. A wrong gain
    scales the load's torque too, friction grows with it, a leaning base turns its weight. LateLoad
    adds what a delay does.
    """
    robot, gain = model.robot, np.ones(model.robot.n)
    direction = np.sign(columns[:, :10 * robot.n] @ model.mean[:10 * robot.n])
    turned = np.zeros_like(load)
    warmth = warmth_of(robot, sample.temperature)
    for use, where in model.slices():
        value = model.mean[where]
        if use.name == 'torque_scale':
            gain[use.joint] += value[0]
        elif use.name == 'torque_scale_temperature':
            gain[use.joint] += value[0] * warmth[use.joint]
        elif use.name == 'load_dependent_friction':
            gain[use.joint] += value[0] * direction[use.joint] * z[use.joint]
        elif use.name == 'base_tilt':
            turned = np.einsum('a,ajk->jk', value, robot.tilted_load_columns(sample.q))
    return gain[:, None] * load + turned


# Without a sensor a joint is anywhere between cold and warm [K, one standard deviation].
UNKNOWN_WARMTH = 12.0


def drift_std(model, known):
    """
    Return (n, 3): standard deviations of offset, Coulomb level and viscous coefficient.

    known (n,) bool: joints whose temperature is measured; the others may be cold or warm.
    """
    drift = model.residuals.drift.copy()
    for use, columns in model.slices():
        if use.name == 'temperature_dependent_viscous_friction' and not known[use.joint]:
            slope = abs(model.mean[columns.start])
            drift[use.joint, 2] = np.hypot(drift[use.joint, 2], slope * UNKNOWN_WARMTH)
    return drift


def nuisance_columns(columns, uncertain, drift, x):
    """
    Return (N, n, r + 3 n): torque of the model's unit-variance uncertainties.

    columns Y (N, n, P); uncertain (P, r); drift (n, 3); x: the EffectInput of the columns.
    """
    count, n = x.q.shape
    out = np.zeros((count, n, uncertain.shape[1] + DRIFTS * n))
    out[:, :, :uncertain.shape[1]] = columns @ uncertain
    joints = np.arange(n)
    for k, basis in enumerate((np.ones_like(x.v), x.z, x.v)):
        out[:, joints, uncertain.shape[1] + k * n + joints] = drift[:, k] * basis
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
    effect = torque_columns(robot, model.layout, x, model.mean) @ root
    rows = (effect * weight[None, :, None]).reshape(count * n, -1)
    _, axes = np.linalg.eigh(rows.T @ rows)
    return root @ axes[:, ::-1][:, :directions]
