"""
Identification motions: multi-sine in every joint, inside all limits, chosen by expected variance.

A motion is a slow part and a fast one, each a Fourier series under a window, so that it begins
and ends at rest in the centre. Of many draws, the best improved by small changes, the one is kept
whose data give the smallest expected variance of predicted torque (V-optimal design).
"""

from dataclasses import dataclass, replace

import numpy as np

from .excitation_information import Information
from .excitation_limits import Clearance, torque_use
from .trajectory import concatenate, Trajectory

OUTPUT_RATE = 100.0
_CHECK_RATE = 50.0
_SLOW_SHARE, _SLOW_SPEED = 0.35, 0.15
_FADE = 1.5
# [Hz] lowest frequency of the fast part; its harmonics reach what an arm's limits allow.
_FAST_LOWEST = 0.08
_SLOW_HARMONICS, _FAST_HARMONICS = 5, 8
# Share of a limit the motion uses; the rest is for what the interpolation and the drive add.
_USE = 0.95
_SHRINK, _SHRINKS = 0.85, 12
# About a minute on one core for six axes and 60 s of motion.
DRAWS, REFINEMENTS = 300, 500


@dataclass(frozen=True)
class Box:
    """Where and how fast: centre, reach [rad], velocity, acceleration, torque, (n,) each."""

    centre: np.ndarray
    reach: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray


def make_box(robot, centre, reach):
    """Return the Box within the robot's limits around centre (n,), at most `reach` [rad] wide."""
    limits = robot.limits
    room = np.minimum(limits.upper - centre, centre - limits.lower)
    return Box(np.array(centre), _USE * np.minimum(reach, room), _USE * limits.velocity,
               _USE * limits.acceleration, _USE * limits.allowed_torque * limits.torque)


class _Part:
    """One windowed Fourier series; coefficients (2 harmonics, n) -> position offset, v, a."""

    def __init__(self, duration, lowest, harmonics, speed_share):
        self.duration, self.speed_share = duration, speed_share
        self._omega = 2.0 * np.pi * lowest * np.arange(1, harmonics + 1)
        self._checked = self.basis(np.linspace(0.0, duration, int(duration * _CHECK_RATE) + 1))

    def basis(self, t):
        """Return the three (T, 2 harmonics) matrices of offset, velocity and acceleration."""
        phase = np.outer(t, self._omega)
        sine, cosine, o = np.sin(phase), np.cos(phase), self._omega
        s = np.hstack([sine, cosine])
        ds = np.hstack([o * cosine, -o * sine])
        dds = np.hstack([-o * o * sine, -o * o * cosine])
        w, dw, ddw = (x[:, None] for x in _window(t, self.duration))
        return w * s, dw * s + w * ds, ddw * s + 2.0 * dw * ds + w * dds

    def fitted(self, coefficients, box):
        """Return the coefficients scaled so that every joint just fills the box."""
        offset, velocity, acceleration = (np.abs(b @ coefficients).max(axis=0)
                                          for b in self._checked)
        scale = np.minimum.reduce([box.reach / offset, self.speed_share * box.velocity / velocity,
                                   box.acceleration / acceleration])
        return coefficients * scale

    def draw(self, random, n):
        """Return random coefficients, lower harmonics larger as the limits want them."""
        order = np.arange(1, len(self._omega) + 1)
        size = order ** -random.uniform(0.0, 1.5)
        return np.tile(size, 2)[:, None] * random.standard_normal((2 * len(order), n))


def _window(t, duration):
    """Return a window that rises and falls over the fade, with two derivatives."""
    fade = min(_FADE, duration / 3.0)

    def rise(s):
        s = np.clip(s, 0.0, 1.0)
        return (s**3 * (10.0 - 15.0 * s + 6.0 * s**2), 30.0 * s**2 * (1.0 - s)**2,
                60.0 * s * (1.0 - s) * (1.0 - 2.0 * s))
    up, down = rise(t / fade), rise((duration - t) / fade)
    first = t < duration / 2.0
    return (np.where(first, up[0], down[0]), np.where(first, up[1], -down[1]) / fade,
            np.where(first, up[2], down[2]) / fade**2)


@dataclass(frozen=True)
class Motion:
    """A chosen motion: coefficients per part, cost, and clearance [m] (see Clearance)."""

    coefficients: tuple
    cost: float
    clearance: float


class Search:
    """Random search and refinement over identification motions of a robot in a Box."""

    def __init__(self, robot, box, duration, noise, seed):
        self._robot, self._box, self._random = robot, box, np.random.default_rng(seed)
        slow = _SLOW_SHARE * duration
        fast = duration - slow
        self._parts = (_Part(slow, 1.0 / slow, _SLOW_HARMONICS, _SLOW_SPEED),
                       _Part(fast, max(1.0 / fast, _FAST_LOWEST), _FAST_HARMONICS, 1.0))
        self.information = Information(robot, box, noise, duration, self._random)
        self._clearance = Clearance(robot)
        step = 1.0 / self.information.rate
        self._sampled = [p.basis(np.arange(0.0, p.duration, step)) for p in self._parts]

    def run(self, progress):
        """Return the best Motion; progress(done, total, cost) is called after each step."""
        best, total = None, DRAWS + REFINEMENTS
        for k in range(DRAWS):
            found = self._rated(tuple(p.draw(self._random, self._robot.n) for p in self._parts))
            best = found if best is None or found.cost < best.cost else best
            progress(k + 1, total, best.cost)
        step = 0.3
        for k in range(REFINEMENTS):
            found = self._rated(self._changed(best.coefficients, step))
            better = found.cost < best.cost
            # One success in five keeps the step, as in evolution strategies.
            step = min(step * 1.2, 1.0) if better else max(step * 0.955, 0.02)
            best = found if better else best
            progress(DRAWS + k + 1, total, best.cost)
        return self._inside_torque(best)

    def trajectory(self, motion):
        """Return the Trajectory of a motion, knots at OUTPUT_RATE."""
        return self._trajectory(motion.coefficients)

    def _evaluate(self, coefficients, bases):
        offset, velocity, acceleration = (
            np.vstack([basis[i] @ c for basis, c in zip(bases, coefficients)]) for i in range(3))
        return self._box.centre + offset, velocity, acceleration

    def _changed(self, coefficients, step):
        changed = []
        for c in coefficients:
            size = np.sqrt(np.mean(c**2, axis=0))
            touched = self._random.random(c.shape[1]) < 0.5
            changed.append(c + step * size * touched * self._random.standard_normal(c.shape))
        return tuple(changed)

    def _rated(self, coefficients):
        """Return the Motion of coefficients fitted into the box and shrunk into the torques."""
        coefficients = tuple(p.fitted(c, self._box) for p, c in zip(self._parts, coefficients))
        for _ in range(_SHRINKS):
            q, v, a = self._evaluate(coefficients, self._sampled)
            if torque_use(self._robot, q, v, a, self._box.torque) <= 1.0:
                break
            coefficients = tuple(_SHRINK * c for c in coefficients)
        clearance = self._clearance.of(q)
        lacking = max(0.0, self._clearance.wanted - clearance) / self._clearance.wanted
        return Motion(coefficients, self.information.cost(q, v, a) * (1.0 + lacking)**4,
                      clearance)

    def _inside_torque(self, motion):
        """Return the motion shrunk until its torque fits between the samples too."""
        for _ in range(_SHRINKS):
            t = self._trajectory(motion.coefficients)
            if torque_use(self._robot, t.position, t.velocity, t.acceleration,
                          self._box.torque) <= 1.0:
                break
            motion = replace(motion, coefficients=tuple(_SHRINK * c for c in motion.coefficients))
        return motion

    def _trajectory(self, coefficients):
        pieces = []
        for part, c in zip(self._parts, coefficients):
            t = np.linspace(0.0, part.duration, int(part.duration * OUTPUT_RATE) + 1)
            q, v, a = self._evaluate((c,), [part.basis(t)])
            pieces.append(Trajectory(t, q, v, a))
        return concatenate(pieces)
