"""Motion and inputs that effects read, and models with chosen effects of stated values."""

from core_helpers import effect_uses, message_noise, true_parameters
import numpy as np

from hand_load_estimator.effects import EFFECTS, EffectInput
from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.motion import Motion
from hand_load_estimator.torque.columns import effect_slices, EffectUse, parameter_count
from hand_load_estimator.torque.lateness import lateness
from hand_load_estimator.torque.play import PlayAlong
from hand_load_estimator.torque.shown_along import shown_along
from hand_load_estimator.torque.shown_friction import course_behind
from hand_load_estimator.torque_model import Residuals, TorqueModel

DT = 0.02


def waves(robot, rng, seconds, celsius):
    """Return a Motion of many sines, filtered as far as identification knows."""
    t = np.arange(int(seconds / DT)) * DT
    q, v, a = (np.zeros((len(t), robot.n)) for _ in range(3))
    for w in 2.0 * np.pi * np.array([0.06, 0.13, 0.21, 0.33, 0.47]):
        size, phase = rng.uniform(0.1, 0.5, robot.n) * 0.6 / w, rng.uniform(0, 6.3, robot.n)
        angle = w * t[:, None] + phase
        q += size * np.sin(angle)
        v += size * w * np.cos(angle)
        a -= size * w * w * np.sin(angle)
    return Motion(t, np.full(len(t), DT), q, v, a, np.zeros_like(q), np.full(q.shape, celsius),
                  np.full(len(t), 10))


def inputs(n=4, count=60, seed=0):
    """Return an EffectInput of random numbers with everything an effect may read."""
    rng, shape = np.random.default_rng(seed), (count, n)
    torque, dt = np.cumsum(rng.normal(size=shape), axis=0), np.full(count, DT)
    q, v, a = (rng.uniform(-size, size, shape) for size in (2, 1, 3))
    warmth, tilt = rng.uniform(-10, 25, shape), rng.normal(size=(*shape, 2))
    return EffectInput(
        q, v, a, warmth, rng.uniform(-1, 1, shape),
        10.0 * rng.normal(size=shape), rng.normal(size=shape), torque, rng.normal(size=shape),
        lambda: tilt, lateness(torque, dt),
        PlayAlong(((torque, 2.0 + np.zeros(shape), dt),), np.full(n, 2.0)),
        shown_of(q, v, a, warmth), at_once=rng.uniform(-1, 1, shape))


def shown_of(q, v, a, warmth):
    """Return what `shown` is of random numbers (N, n)."""
    dt, n = np.full(len(q), DT), q.shape[1]
    return shown_along(course_behind(q, v, a, dt), dt, warmth,
                       (np.full(n, 1e-3), np.full(n, np.inf)))


def model_with(robot, names, values, shape=None):
    """Return a TorqueModel of nominal links, plain friction and effects of stated values."""
    plain = effect_uses(robot)
    added = tuple(EffectUse(name, j, {s.name: (shape or {}).get(s.name, s.default)
                                      for s in EFFECTS[name].shapes})
                  for name in names for j in range(robot.n)
                  if not (EFFECTS[name].whole_arm and j))
    uses = added if not values else plain + added
    mean = np.zeros(parameter_count(robot.n, uses))
    mean[:10 * robot.n] = robot.nominal_links
    if values:
        mean[:parameter_count(robot.n, plain)] = true_parameters(robot, plain)
    for use, where in effect_slices(robot.n, uses):
        if use.name in values:
            mean[where] = values[use.name]
    noise = message_noise(robot)
    return TorqueModel(robot, uses, False, mean, np.diag((0.01 * mean) ** 2), Residuals(
        noise, noise ** 2 * DT, np.zeros((robot.n, 3))), (RecordingMark('made up'),),
        (15.0, 45.0))
