"""
Collision thresholds that follow the load (E9.1) and widen with its variance (E9.2).

A collision is a torque that neither the torque model nor the load explains. The threshold of a
joint is the sum of what they may be wrong by: the model's band and the load's band.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from .load_belief import any_rated_belief
from .model_doubt import ModelDoubt


@dataclass(frozen=True)
class ThresholdSettings:
    """
    Where a torque begins to be a collision.

    margin: times the torque model's noise; sigma > 0: standard deviations of the load's torque
    and of the torque model's; inertia_share: part of the accelerating torque that model, load
    and timing may be wrong by; slow [rad/s]: below it the direction of friction is not known;
    debounce: residuals in a row, or debounce_time [s] of them if that is shorter; delay [s]: how
    much later than the motion the residual torque shows it (estimator's filter, message);
    relax_time [s]: time constant of a falling threshold.
    """

    margin: float = 6.0
    sigma: float = 3.0
    inertia_share: float = 0.2
    slow: float = 0.05
    debounce: int = 3
    debounce_time: float = 0.2
    delay: float = 0.06
    relax_time: float = 0.3


@dataclass(frozen=True)
class Thresholds:
    """What the residual torque should be, and how far from it is a collision, (n,) [Nm] each."""

    expected: np.ndarray
    threshold: np.ndarray


class CollisionThresholds:
    """Computes thresholds along a motion; model is a TorqueSource."""

    def __init__(self, model, settings=ThresholdSettings()):
        self._model, self._settings = model, settings
        self._doubt = ModelDoubt(model)
        self._fixed = any_rated_belief(model.robot, settings.sigma)

    def at(self, q, v, a, belief, temperature, standing=False):
        """
        Return (Thresholds, fixed (n,)) at a state of motion.

        belief: the trusted estimate, or one with source `rated`; fixed: the threshold without
        knowledge of the load. No threshold is above it: joint by joint the tighter holds.
        standing (n,): joints that have not set off yet although they were told to.
        """
        state = q, v, a, temperature
        # A joint at rest may hold any torque up to its friction, in either direction.
        speed = np.where(standing, 0.0, np.abs(v))
        slowness = np.clip(2.0 - speed / self._settings.slow, 0.0, 1.0)
        base = self._model_band(*state, slowness)
        expected, band = self._load_band(self._fixed, state, slowness)
        fixed = base + band
        if belief.source == 'estimate':
            mean, narrow = self._load_band(belief, state, slowness)
            # Not finite is not tighter: then the threshold stays the fixed one.
            tighter = narrow < band
            expected, band = np.where(tighter, mean, expected), np.where(tighter, narrow, band)
        return Thresholds(expected, base + band), fixed

    def _load_band(self, belief, state, slowness):
        """Return the load's expected torque and what it may be wrong by, (n,) each."""
        (q, v, a, temperature), settings = state, self._settings
        still, creep = np.zeros_like(q), np.full_like(q, settings.slow)

        def regressor(v, a):
            # The residual torque holds nothing of what a load does to the arm's own friction.
            return self._model.load_while_sliding(q, v, a, temperature, belief.mean)[0]

        mean, std = belief.torque(regressor(v, a))
        inertia = np.abs(mean - regressor(v, still) @ belief.mean)
        friction = 0.5 * np.abs((regressor(creep, still) - regressor(-creep, still)) @ belief.mean)
        return mean, settings.sigma * std + settings.inertia_share * inertia \
            + 2.0 * slowness * friction

    def _model_band(self, q, v, a, temperature, slowness):
        """Return what the torque model may be wrong by (n,)."""
        settings, still = self._settings, np.zeros_like(q)
        torque = self._model.torque
        inertia = np.abs(torque(q, v, a, temperature) - torque(q, v, still, temperature))
        creep = np.full_like(q, settings.slow)
        friction = 0.5 * np.abs(torque(q, creep, still, temperature)
                                - torque(q, -creep, still, temperature))
        return settings.margin * self._model.noise + settings.inertia_share * inertia \
            + 2.0 * slowness * friction + settings.sigma * self._doubt.std(q, v, a, temperature)


class CollisionDetector:
    """
    Compares residual torques with the thresholds of the time they belong to.

    collided stays true until reset(); what: the joint indices, residual and threshold.
    """

    def __init__(self, settings=ThresholdSettings()):
        self._settings, self._history, self._count = settings, deque(), 0
        self._last, self._deaf_until, self._since = None, -np.inf, None
        self.collided, self.what = False, None

    def record(self, now, thresholds, fixed):
        """
        Take the Thresholds valid at `now` [s] and return them as they are in force.

        They rise at once and fall slowly; never above `fixed` (n,).
        """
        threshold = thresholds.threshold
        if self._last is not None and now >= self._last[0]:
            fade = np.exp(-(now - self._last[0]) / self._settings.relax_time)
            fading = threshold + (self._last[1] - threshold) * fade
            threshold = np.maximum(threshold, np.minimum(fading, fixed))
        elif self._last is not None:
            self._history.clear()
            self._deaf_until, self._count = -np.inf, 0
        self._last = (now, threshold)
        in_force = Thresholds(thresholds.expected, threshold)
        self._history.append((now, in_force))
        while now - self._history[0][0] > 0.5:
            self._history.popleft()
        return in_force

    def judges(self, stamp):
        """Tell whether it is known what was expected of a residual torque of `stamp` [s]."""
        return any(self._is_of(t, stamp) for t, _ in reversed(self._history))

    def _is_of(self, time, stamp):
        return -self._settings.delay <= time - stamp <= 1e-3

    def check(self, stamp, residual):
        """
        Judge a residual torque (n,) [Nm] of `stamp` [s]; return whether a collision is known.

        The residual is a filtered torque: it belongs to a stretch of `delay` before its stamp,
        so what is expected may be anything expected during it.
        """
        stretch = [entry for t, entry in self._history if self._is_of(t, stamp)]
        if not stretch or stamp < self._deaf_until or not np.isfinite(residual).all():
            return self.collided
        expected = np.array([entry.expected for entry in stretch])
        threshold = np.max([entry.threshold for entry in stretch], axis=0)
        beyond = np.maximum(residual - expected.max(axis=0), expected.min(axis=0) - residual)
        # A threshold that is not a number must not switch the detection off.
        hit = ~(beyond <= threshold)
        if self._lasting(stamp, hit.any()) and not self.collided:
            self.collided = True
            self.what = (np.flatnonzero(hit), beyond, threshold)
        return self.collided

    def _lasting(self, stamp, hit):
        """Tell whether enough residuals in a row were beyond, or they were for long enough."""
        self._count = self._count + 1 if hit else 0
        if self._count == 1:
            self._since = stamp
        return self._count >= self._settings.debounce or (
            self._count > 1 and stamp - self._since >= self._settings.debounce_time - 1e-9)

    def reset(self):
        """Forget the collision, and what residual torques still tell of it."""
        if self._last is not None:
            self._deaf_until = self._last[0] + self._settings.delay
        self.collided, self.what, self._count = False, None, 0
