"""An arm right but for hidden effects, its recordings, and what a diagnosis finds in them."""

from dataclasses import replace
from functools import lru_cache

from core_helpers import effect_uses, four_axes, true_parameters
from effect_helpers import DT, waves
import numpy as np

from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED
from hand_load_estimator.torque.columns import (ColumnLayout, play_columns, presliding_distances,
                                                torque_columns)
from hand_load_estimator.torque.contact_level import contact_level
from hand_load_estimator.torque.motion_inputs import motion_input
from hand_load_estimator.torque_model import Residuals, TorqueModel

RUNS, SECONDS = 4, 16.0


@lru_cache(None)
def declared_model(doubt=0.01, names=None):
    """Return the TorqueModel of the arm, right but for hidden effects; doubt: relative std."""
    robot = four_axes()
    uses = effect_uses(robot) if names is None else effect_uses(robot, names)
    mean = true_parameters(robot, uses)
    std = doubt * np.abs(mean)
    std[:10 * robot.n] = 0.0
    noise = noise_of(robot)
    return TorqueModel(robot, uses, False, mean, np.diag(std ** 2), Residuals(
        noise, noise ** 2 * DT, np.zeros((robot.n, 3))), (RecordingMark('made up'),),
        (15.0, 35.0))


def noise_of(robot):
    """Return the RMS (n,) [Nm] of one row's torque noise."""
    return 4e-3 * robot.limits.torque


class Hidden:
    """What a hidden effect may use of one run: EffectInput x, its times and the torque so far."""

    def __init__(self, robot, x, motion, torque):
        self.robot, self.x, self.motion, self.torque = robot, x, motion, torque
        self.noise = noise_of(robot)


@lru_cache(None)
def clean_runs(seconds, names=None, celsius=(15.0, 35.0)):
    """Return (EffectInput, Motion, torque without noise (N, n)) of each run."""
    model = declared_model(names=names)
    robot, rng, runs = model.robot, np.random.default_rng(11), []
    for k in range(RUNS):
        motion = waves(robot, rng, seconds, celsius[k % 2])
        uses = effect_uses(robot)
        truth = true_parameters(robot, uses)
        x, _ = motion_input(robot, motion, presliding_distances(robot.n, uses),
                            level=contact_level(robot, uses, truth))
        torque = torque_columns(robot, ColumnLayout(robot.n, uses), x) @ truth
        runs.append((x, motion, torque))
    return runs


def recorded(*hidden, seconds=SECONDS, seed=5, names=None, celsius=(15.0, 35.0)):
    """Return the Evidence of RUNS runs of the arm with hidden effects: functions of Hidden."""
    robot, rng = declared_model(names=names).robot, np.random.default_rng(seed)
    found = []
    for k, (x, motion, torque) in enumerate(clean_runs(seconds, names, celsius)):
        noise = rng.normal(size=torque.shape) * noise_of(robot)
        more = sum((effect(Hidden(robot, x, motion, torque)) for effect in hidden),
                   np.zeros_like(torque))
        found.append(Evidence(f'run {k}', motion, torque + more + noise))
    return found


def cut(evidence, rows):
    """Return the Evidence of some of its rows only."""
    return replace(evidence, torque=evidence.torque[rows], motion=evidence.motion.part(rows))


def diagnosed(*hidden, model=None, **keywords):
    """Return (Diagnosis, better model) of an arm with hidden effects; the last run is to test."""
    evidence = recorded(*hidden, **keywords)
    return diagnose(model or declared_model(), evidence[:-1], evidence[-1:])


def told(diagnosis):
    """Return the confirmed findings as a mapping of name to joints."""
    return {f.name: f.joints for f in diagnosis.findings if f.verdict == CONFIRMED}


def on(joint, times, function):
    """Return an effect of one joint with an RMS of so many times the noise: function(Hidden)."""
    robot = declared_model().robot
    whole = np.concatenate([function(Hidden(robot, *run))[:, joint]
                            for run in clean_runs(SECONDS)])
    size = times * noise_of(robot)[joint] / np.sqrt(np.mean(whole ** 2))

    def effect(run):
        out = np.zeros_like(run.torque)
        out[:, joint] = size * function(run)[:, joint]
        return out
    return effect


def alone(effect, joint):
    """Return an effect (function of Hidden) on one joint only."""
    return lambda run: effect(run) * (np.arange(run.robot.n) == joint)


def ripple(run):
    """A ripple slow enough to pass the motion filter as it is."""
    return np.sin(23.4 * run.x.q + 0.5)


def cable(run):
    return np.exp(0.9 * run.x.q) - 1.0


def viscous(run):
    return run.x.v


def late(run):
    """Effort of one sample ago, on all joints."""
    return np.concatenate([run.torque[:1], run.torque[:-1]]) - run.torque


def a_little_late(run):
    """Effort of 9 ms ago, on all joints."""
    time = run.motion.stamp
    return np.stack([np.interp(time - 0.009, time, torque) for torque in run.torque.T],
                    axis=1) - run.torque


def misread(run):
    """Effort 2 % too large, on all joints."""
    return 0.02 * run.torque


def play(run):
    """Every gear with a gap of 4 mrad."""
    gear = np.array([run.robot.rigid_torque(*row) for row in zip(run.x.q, run.x.v, run.x.a)])
    return play_columns(run.robot, run.x.q, gear, run.motion.dt)(
        np.arange(4), np.full(4, 0.004), np.full(4, 0.012), np.ones(4), np.full(4, 0.009))


def leaning(run, x=0.02, y=-0.03):
    """Gravity turned by small angles [rad] about x and y, exactly."""
    tilted = four_axes(gravity=(turned(x, y) @ [0.0, 0.0, -9.81]).tolist())
    zero = np.zeros(4)
    return np.array([tilted.rigid_torque(q, zero, zero) - run.robot.rigid_torque(q, zero, zero)
                     for q in run.x.q])


def heavier_links(run):
    """Links other than declared: heavier ones, and some whose centre of mass is elsewhere."""
    layout = ColumnLayout(run.robot.n, ())
    links = np.zeros((run.robot.n, 10))
    links[:, :4] = np.array([[0.5], [0.3], [0.4], [0.2]]) * [1.0, 0.1, -0.08, 0.05]
    return torque_columns(run.robot, layout, run.x) @ links.ravel()


def turned(x, y):
    """Return the rotation by a small vector (x, y, 0) [rad]."""
    k = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
    angle = np.hypot(x, y)
    return np.eye(3) + np.sin(angle) / angle * k + (1.0 - np.cos(angle)) / angle ** 2 * k @ k


def resonance(run):
    """Friction with a narrow peak in speed: no effect of the vocabulary."""
    return np.sign(run.x.v) * np.exp(-((np.abs(run.x.v) - 0.45) / 0.05) ** 2)


def warming(run):
    return np.sign(run.x.v) * run.x.warmth


def stretched(run):
    """A rotor heavier than declared."""
    return run.x.a


def turned_late(run):
    """Friction that turns over a long way, and then is at its level."""
    return run.x.shown(np.arange(run.robot.n), 0.02, 0.8) - run.x.z


def peak(run):
    """A Stribeck peak as the motion filter shows it."""
    return run.x.shown(np.arange(run.robot.n), 2e-3, np.inf, 0.1)


def narrow_peak(run):
    """A peak that falls faster than by 1 / e, the later the warmer the joint."""
    return run.x.shown(np.arange(run.robot.n), 2e-3, np.inf, 0.1, 1.8, 30.0)


def levelling(run):
    """Friction of a fluid that levels off, as the plainest of Cross's curves."""
    return run.x.v / (0.3 + np.abs(run.x.v))


def thinning(run):
    """A power-law fluid: friction with the square root of speed."""
    return np.sign(run.x.v) * np.sqrt(np.abs(run.x.v))


def constant_friction(run):
    return run.x.z


def assert_only(diagnosis, name, joints, alternatives=()):
    """Hold that one effect was found, and what it was not told apart from."""
    assert [f.name for f in diagnosis.findings] == [name]
    found = diagnosis.findings[0]
    robot = declared_model().robot
    assert found.joints == tuple(robot.joints[j] for j in joints)
    assert found.verdict == CONFIRMED
    assert set(alternatives) <= {other.name for other in found.alternatives}
    assert found.evidence.gain > found.evidence.needed > 8.0
    return found


def assert_repaired(diagnosis, joint):
    """Hold that a joint's error goes back to its noise and no other joint's grows."""
    noise = noise_of(declared_model().robot)
    assert diagnosis.before[joint] > 1.3 * noise[joint]
    assert (diagnosis.after < 1.12 * noise).all()
    assert (diagnosis.after <= diagnosis.before * 1.005).all()
