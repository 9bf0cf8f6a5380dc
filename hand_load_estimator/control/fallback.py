"""Which load to count on now: the estimate while it can be trusted, else the rated load."""

from dataclasses import dataclass

import numpy as np

from .load_belief import beside, belief_of_estimate, rated_belief

TRUSTED = ('ESTIMATING', 'DETERMINED')
# The mass the status tells has six digits.
_SAME_MASS = 1e-3


@dataclass(frozen=True)
class FallbackSettings:
    """
    When to fall back to the rated load, and how to come back from it.

    timeout [s]: age at which an estimate or status is stale; residual_timeout [s]: age at which
    the residual torque is, and no collision would be noticed; relax_time [s]: from the rated
    load's limits to the estimate's (the other way is at once); confirm_time [s] of measured
    motion after which an expected load change that the estimator has not seen did not happen.
    """

    timeout: float = 0.5
    relax_time: float = 0.5
    confirm_time: float = 0.5
    residual_timeout: float = 0.2


def usable_estimate(mean, covariance, known_mass=0.0):
    """
    Return why mean and covariance in message order cannot be used; empty when they can.

    known_mass [kg]: of what is held beside the estimate.
    """
    mean, covariance = np.asarray(mean, dtype=float), np.asarray(covariance, dtype=float)
    if mean.shape != (10,) or covariance.shape != (10, 10):
        return 'estimate_size'
    if not (np.isfinite(mean).all() and np.isfinite(covariance).all()):
        return 'estimate_not_finite'
    if np.linalg.eigvalsh(0.5 * (covariance + covariance.T))[0] < -1e-6 * np.trace(covariance):
        return 'covariance_not_positive'
    if mean[0] + known_mass < -3.0 * np.sqrt(max(covariance[0, 0], 0.0)):
        return 'negative_mass'
    return ''


class LoadPolicy:
    """
    Follows the estimator and decides what load motions are planned for.

    belief: LoadBelief to plan with; caution in [0, 1]: 1 after a fallback, falling to 0 while
    the estimate is trusted; reason: why the estimate is not trusted, empty when it is. The
    estimate is kept from motion to motion while the load is the same (E8.4). blind: why no
    collision would be noticed, empty when it would; a reason for the rated load's limits too.
    known (10,): products of what is held beside the estimate, a tool or what was tared.
    """

    def __init__(self, robot, settings=FallbackSettings()):
        self._settings, self._rated = settings, rated_belief(robot)
        self._estimate, self._estimate_time = None, -np.inf
        self._status, self._status_time, self._load_id = 'NO_DATA', -np.inf, None
        self._residual_stamp, self.blind = -np.inf, 'no residual torque has arrived'
        self._unjudged = False
        self._expected_after, self._moved, self._now = None, 0.0, None
        self.known, self._known_mass = np.zeros(10), 0.0
        self.caution, self.reason = 1.0, 'no estimate has arrived'

    @property
    def trusted(self):
        """Whether the estimate is used."""
        return not self.reason

    @property
    def belief(self):
        """The LoadBelief to plan with now."""
        return beside(self._estimate, self.known) if self.trusted else self._rated

    def estimate(self, now, mean, covariance):
        """Take a usable estimate in message order that arrived at `now` [s]."""
        self._estimate, self._estimate_time = belief_of_estimate(mean, covariance), now

    def status(self, now, status, load_id, known_mass=0.0):
        """Take status, count of load changes, and the mass [kg] held beside the estimate."""
        self._status, self._status_time, self._load_id = status, now, load_id
        self._known_mass = known_mass
        if status not in TRUSTED:
            self._distrust(f'the estimator says {status}')

    def residual(self, stamp, judged=True):
        """Note that a residual torque of `stamp` [s] has arrived, and whether it can be judged."""
        self._unjudged = not judged
        if judged:
            self._residual_stamp = stamp

    @property
    def expecting(self):
        """Whether the load is about to change, or has, and nothing has told of it yet."""
        return self._expected_after is not None

    def expect_change(self):
        """
        Distrust what is known: the hand is about to grip or release.

        Until the estimator has counted a load change, or has seen motion without one.
        """
        self._expected_after, self._moved = (self._load_id,), 0.0
        self._distrust('the hand has gripped or released')

    def update(self, now, moving):
        """Judge the estimate at `now` [s]; moving: whether a joint that carries the load does."""
        step = 0.0 if self._now is None else max(0.0, now - self._now)
        self._now = now
        self.blind, unheard = self._judge_residual(now), self._judge_age(now)
        # What nobody estimated from tells nothing.
        self._moved = 0.0 if unheard else self._moved + step * moving
        reason = unheard or self._judge() or self.blind
        if reason:
            self._distrust(reason)
            return
        self.reason = ''
        relaxed = step / self._settings.relax_time if self._settings.relax_time else 1.0
        self.caution = max(0.0, self.caution - relaxed)

    def _distrust(self, reason):
        self.reason, self.caution = reason, 1.0

    def _judge_age(self, now):
        if self._estimate is None:
            return 'no estimate has arrived'
        for what, since in (('estimate', self._estimate_time), ('status', self._status_time)):
            if not -self._settings.timeout <= now - since <= self._settings.timeout:
                return f'the last {what} is {now - since:.2f} s old'
        return '' if self._status in TRUSTED else f'the estimator says {self._status}'

    def _judge(self):
        # A mass that is no number is not known here either.
        apart = abs(self.known[0] - self._known_mass)
        if not apart <= _SAME_MASS * max(1.0, abs(self._known_mass)):
            return (f'{self._known_mass:.3g} kg are held beside the estimate (tool, tare), and '
                    f'{self.known[0]:.3g} kg of them are known here')
        if self._expected_after is not None:
            if (self._load_id,) == self._expected_after \
                    and self._moved < self._settings.confirm_time:
                return 'the hand has gripped or released'
            self._expected_after = None
        return ''

    def _judge_residual(self, now):
        age = now - self._residual_stamp
        if self._unjudged and not 0.0 <= age <= self._settings.residual_timeout:
            return ('residual torques arrive with stamps for which nothing is expected: no '
                    'collision would be noticed')
        if np.isinf(age):
            return 'no residual torque has arrived'
        if abs(age) > self._settings.residual_timeout:
            return f'the last residual torque is {age:.2f} s old: no collision would be noticed'
        return ''
