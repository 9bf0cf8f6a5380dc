"""Find the residual: what a torque model leaves of recordings, and what of it is noise."""

from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from ...effects import EFFECTS, EffectInput, LATE
from ...effects.effect import SLOWEST
from ...identification.evidence import recording_numbers
from ...motion import smeared
from ...torque.columns import (EffectUse, gear_torque, play_columns, tilt_along,
                               torque_columns)
from ...torque.filtered_noise import noise_floor, white_density
from ...torque.lateness import as_reported, change_when_late, lateness
from ...torque.motion_inputs import known_motion, motion_inputs
from ...torque.play import PlayAlong
from ...torque.presliding import stuck_density
from ...torque.shown_along import followed_together, shown_as_one
from ...torque.sliding import surely_slides
from ...torque_model import drift_std, nuisance_columns, uncertain_directions
from .blocks import Blocks
from .folds import Cut, cut_into_blocks, UNCUT
from .noisier import times_noisier
from .repeats import first_shown

# Information, in units of the prior's, from which on a direction of the parameters counts.
TOLD = 0.1
# A model made without an effect took it for noise. What is left may be so many times denser at low
# frequencies than its white part, but no more; and at least this share of what the model states
# is noise, because recordings that were smoothed show no white part at all.
COLOUR, STRUCTURE = 10.0, 0.1
# Directions of the model's own uncertainty that count as nuisances.
DIRECTIONS = 20


@dataclass(frozen=True)
class Residual:
    """
    The residual of several recordings along their motion, N rows in all.

    x: EffectInput with everything effects may read; residual, weights (N, n) [Nm], [1/(Nm^2 s) s];
    turning (N, n): weights that count reversals as much as sliding, for what tells how friction
    turns; columns Y (N, n, P) of the model, of which prompt (P,) are of no delay; dt, time (N,)
    [s]; messages (N,): joint states of each row; owner (N,): part of a recording; loads:
    LoadParameters known to be held in each; cut: into blocks; moving (N, n): where joints slide;
    sliding (N, n): where they slide by the watch's stricter measure (sliding.py); expected (n,)
    [Nm]: RMS of the torque that the model itself says it may be wrong by; noise (n,) [Nm]: RMS
    of what the model leaves that is surely noise; noisier (K, n): how many times as dense as the
    model states the noise of each part is, None for as stated; delays {joint: [s]}: how late a
    joint was found to report its torque, declared what the model says of that.
    """

    x: EffectInput
    residual: np.ndarray
    weights: np.ndarray
    turning: np.ndarray
    columns: np.ndarray
    prompt: np.ndarray
    dt: np.ndarray
    time: np.ndarray
    messages: np.ndarray
    owner: np.ndarray
    loads: tuple
    cut: Cut
    moving: np.ndarray
    sliding: np.ndarray
    expected: np.ndarray
    noise: np.ndarray
    noisier: np.ndarray | None = None
    delays: dict = field(default_factory=dict)
    declared: dict = field(default_factory=dict)
    _paths: dict = field(default_factory=dict)

    @property
    def starts(self):
        """First rows (B,) of the blocks."""
        return self.cut.starts

    @property
    def folds(self):
        """Folds (B,) of the blocks."""
        return self.cut.folds

    @property
    def interval(self):
        """Time between two joint states [s], as it is mostly."""
        return float(np.median(self.dt / self.messages))

    @property
    def longest_interval(self):
        """The same [s] of the part where it is longest."""
        each = self.dt / self.messages
        return max(float(np.median(each[self.owner == k])) for k in np.unique(self.owner))

    @property
    def observations(self):
        """Number of groups of blocks: repetitions of one motion are one."""
        return int(self.cut.groups.max()) + 1

    def reported(self, columns):
        """Return columns {joint: (N, k)} of the moments that the torques reported belong to."""
        return {j: own + change_when_late(own, self.dt, self.owner, self.delays[j])
                if j in self.delays else own for j, own in columns.items()}

    def all_reported(self, columns):
        """Return the same of columns (N, n, k) of all joints."""
        late = self.reported({j: columns[:, j] for j in self.delays})
        return np.stack([late.get(j, columns[:, j]) for j in range(columns.shape[1])], axis=1)

    def friction_state(self, distance, plastic):
        """Return z (N, n) of all joints for a travel [rad] and `plastic` of presliding.Turning."""
        self.follow_friction(((distance, plastic),))
        return self._paths[distance, plastic]

    def follow_friction(self, ways):
        """Follow the friction state for (travel [rad], plastic) pairs at once, unless known."""
        ways = [way for way in ways if way not in self._paths]
        n = self.residual.shape[1]
        if not ways:
            return
        followed = followed_together(self.x.shown.parts, [
            (np.full(n, distance), np.full(n, plastic)) for distance, plastic in ways])
        self._paths.update({way: shown_as_one(shown).z for way, shown in zip(ways, followed)})

    def as_noisy_as(self, rest, stated):
        """
        Return the Residual with as much noise as a rest (N, n) [Nm] of it shows.

        The same where that is about as dense as stated (n,) [Nm^2 s].
        """
        times = np.array([times_noisier(rest[own], self.dt[own], self.messages[own], stated)
                          for own in (self.owner == k for k in range(self.owner[-1] + 1))])
        if (times == 1.0).all():
            return self
        return replace(self, noisier=times, weights=self.weights / times[self.owner],
                       turning=self.turning / times[self.owner],
                       noise=self.noise * np.sqrt(times.max(axis=0)))

    def blocks(self, root=None):
        """
        Return the Blocks to compare hypotheses on.

        root (P, P): square root of the covariance that the model's own parameters are fitted with
        again beside every hypothesis; None keeps them as they are.
        """
        count, n = self.residual.shape
        nuisances = [np.zeros((count, 0)) if root is None else self._leading(j, root)
                     for j in range(n)]
        return Blocks(self.residual, self.weights, nuisances, self.starts, self.folds,
                      self.cut.groups)

    def _leading(self, j, root):
        """Return (N, R): directions of the parameters that joint j tells anything about."""
        late = self.reported({j: self.columns[:, j]})[j]
        columns = np.where(self.prompt, late, self.columns[:, j]) @ root
        values, axes = np.linalg.eigh((columns * self.weights[:, j, None]).T @ columns)
        return columns @ axes[:, values > TOLD]


def find_residual(model, evidence, cut=True):
    """
    Return the Residual of a TorqueModel on Evidence (evidence.prepare).

    cut: into blocks, to compare hypotheses on.
    """
    root = uncertain_directions(model, DIRECTIONS, 0)
    inputs = next(motion_inputs(model.robot, [e.motion for e in evidence],
                                [(model.presliding_distance(), model.presliding_plastic())],
                                model.contact_level()))
    parts = [_of_recording(model, root, *own, cut) for own in zip(evidence, inputs)]
    joined = {name: np.concatenate([p[name] for p in parts]) for name in parts[0] if name != 'x'}
    x = _joined_input([p['x'] for p in parts])
    owner = np.concatenate([np.full(len(p['dt']), k) for k, p in enumerate(parts)])
    recording = np.array(recording_numbers(evidence))[owner]
    pieces = cut_into_blocks(joined['dt'], owner, recording, first_shown(
        x.q, x.v, joined['dt'], owner)) if cut else UNCUT
    floor = noise_floor(joined['residual'], joined['dt'], joined['messages'])
    noise = np.clip(floor, np.sqrt(STRUCTURE) * model.noise, model.noise)
    own, doubt = declared_delays(model), joined.pop('doubt')
    return Residual(x, owner=owner, loads=tuple(e.load for e in evidence),
                    prompt=model.layout.prompt, cut=pieces, noise=noise,
                    delays=own, declared=own, expected=np.sqrt(doubt.mean(axis=0)), **joined)


def declared_delays(model):
    """Return {joint: delay [s]} that a TorqueModel states; a share of nothing is none."""
    shares = {use.joint: (float(model.mean[where.start]), use.shape['shift'])
              for use, where in model.slices() if use.name == LATE}
    return {j: share * shift for j, (share, shift) in shares.items() if share > 0.0}


def _joined_input(parts):
    names = [name for name in EffectInput.__dataclass_fields__
             if name not in ('late', 'play', 'shown', 'tilt')
             and getattr(parts[0], name) is not None]
    tilt = parts[0].tilt and cache(lambda: np.concatenate([p.tilt() for p in parts]))
    late = parts[0].late and (lambda delay: np.concatenate([p.late(delay) for p in parts]))
    play = parts[0].play and PlayAlong(tuple(own for p in parts for own in p.play.parts),
                                       parts[0].play.usual)
    return EffectInput(
        **{name: np.concatenate([getattr(p, name) for p in parts]) for name in names}, late=late,
        play=play, tilt=tilt, shown=shown_as_one([p.shown for p in parts]))


def _doubt(model, root, columns, x, temperature):
    """
    Return the variance (N, n) [Nm^2] of what the model's covariance and drift may do.

    root (P, r): the covariance's leading directions. A joint of unknown temperature may have the
    friction of any.
    """
    drift = drift_std(model, np.isfinite(temperature).any(axis=0))
    return (nuisance_columns(columns, root, drift, x.z, x.v) ** 2).sum(axis=2)


def _of_recording(model, root, evidence, given, compared):
    """
    Return the row-wise fields of a Residual for one recording, to compare hypotheses or not.

    given: what motion_inputs has of it.
    """
    robot, motion, (x, doubt) = model.robot, evidence.motion, given
    links = known_motion(robot, motion).links
    columns = torque_columns(robot, model.layout, x, model.mean, motion.dt, evidence.load,
                             links=links)
    if compared:
        x = _complete(model, x, columns, motion.dt, evidence.load, links)
    level, residual = model.friction_level(), evidence.torque - columns @ model.mean
    stated = model.residuals.intensity
    white = white_density(residual, motion.dt, motion.messages)
    sliding = np.clip(COLOUR * white, STRUCTURE * stated, stated)
    stuck = stuck_density(x.z, doubt, x.v, level)
    density = sliding + as_reported(model.uses, stuck, motion.dt, np.zeros(len(motion.dt)))
    tells = evidence.tells
    known = (doubt < 0.1) & (np.abs(x.v) > SLOWEST) & tells
    # Within the filter's memory of a reversal mostly how friction turns shows, of which no formula
    # is exact: what is left of it is no other effect.
    weights = np.where(smeared(x.v, x.a) | ~tells, 0.0, motion.dt[:, None] / density)
    moving = known & (np.abs(x.z) > 0.9)
    return {'x': x, 'residual': residual, 'weights': weights, 'columns': columns,
            'turning': np.where(known, motion.dt[:, None] / sliding, 0.0),
            'dt': motion.dt, 'time': motion.stamp, 'messages': motion.messages, 'moving': moving,
            'sliding': surely_slides(x.v, x.z, doubt) & tells,
            'doubt': _doubt(model, root, columns, x, motion.temperature)}


def _complete(model, x, columns, dt, load, links):
    """
    Return an EffectInput with the torques that effects outside the model may read.

    links: shown_links_and_way of it.
    """
    n, robot = model.robot.n, model.robot
    gear, way = gear_torque(robot, *links, model.mean, load)
    held = gear - columns[:, :, :10 * n] @ model.mean[:10 * n]
    pull, pull_way = model.link_pull(x, load.to_products())
    gear, way = gear + pull, way + pull_way
    predicted = columns @ model.mean + held
    # A gain is delayed with everything else by the delays that the model declares.
    drive = model.layout.prompt_torque(columns, model.mean) + held
    rate = np.diff(predicted, axis=0, prepend=predicted[:1]) / dt[:, None]
    return replace(x, gear=gear, gear_way=way, drive=drive, rate=rate,
                   late=lateness(predicted, dt),
                   play=play_columns(robot, x.q, gear, dt),
                   tilt=tilt_along(robot, model.layout, x.q, model.mean, load.to_products()))


def use_of(name, joint, shape):
    """Return the EffectUse of a hypothesis."""
    return EffectUse(name, 0 if EFFECTS[name].whole_arm else joint, shape)
