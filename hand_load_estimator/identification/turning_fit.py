"""
How a joint's friction turns, settled beside everything else of the joint.

A search beside a model that stays as it is sees only what Coulomb friction does in another way of
turning. What else turns with it, and how far its figures are off by then, moves the best way by
more than it is known by. With a Stribeck peak the contacts bend up to a level that falls with
speed, so that its form settles with the way of turning.
"""

from dataclasses import replace

import numpy as np

from ..effects import PRESLIDING
from ..effects.effect import SLOWEST
from ..effects.own_travel import BOTH, OWN_TRAVEL, PLASTIC
from .regression_system import System
from .shape_search import joint_residuals, PRICES, TRAVEL

PEAK = 'stribeck_friction'
TURNS = 6
# Steps that tell slopes: of the logarithm of the travel, of the plastic way [levels]; of a peak
# the logarithm of its velocity, its exponent, and what it gains per kelvin. What they may be.
STEPS = np.array([0.04, 0.1, 0.05, 0.05, 2e-3])
LEAST_PLACE = np.array([np.log(1e-5), PLASTIC.least, np.log(SLOWEST), 0.5, 0.0])
MOST_PLACE = np.array([0.0, BOTH, 0.0, 3.0, 0.1])
# How much of a slope's square a step is damped by at first; so many times less or more later.
DAMPED, LESS, MORE = 1e-3, 0.1, 10.0
# [nats] that settling must gain: noise moves a way by less.
LEAST = 5.0


def with_turning_fitted(system, uses, evidence, x, intensity, joints, peaks=frozenset()):
    """
    Return uses whose joints (indices) turn as all effects of each fit best.

    system: the System of uses and Evidence; x (P,): tells the torque of all else, and of how much
    of a joint's friction is a peak; intensity (n,) [Nm^2 s] of the residual; peaks: joints whose
    peak settles, too, and turns as all other friction of the joint then. Where all that gains less
    than LEAST nothing changes.
    """
    joints = [j for j in joints if _use(uses, PRESLIDING, j)]
    if not joints:
        return uses
    weights = system.turning_weights(intensity)

    def left_at(places):
        """Return what is left (J, N) at places (J, 5), in nats' roots, and prices (J,)."""
        left = _residuals(system, _at(uses, joints, places, peaks), evidence, x, weights,
                          joints)
        return left, 2.0 * PRICES[PLASTIC.name] * (places[:, 1] < BOTH)
    before = (_residuals(system, uses, evidence, x, weights, joints) ** 2).sum(axis=1)
    best = np.array([_place(uses, j) for j in joints])
    before += 2.0 * PRICES[PLASTIC.name] * (best[:, 1] < BOTH)
    left, price = left_at(best)
    free = np.array([_free(uses, j, j in peaks) for j in joints])
    damped = np.full(len(joints), DAMPED)
    for _ in range(TURNS):
        slopes = _slopes(lambda places: left_at(places)[0], best, left, free)
        there = np.clip(best + _steps(slopes, left, free, damped), LEAST_PLACE, MOST_PLACE)
        found, costs = left_at(there)
        better = (found ** 2).sum(axis=1) + costs < (left ** 2).sum(axis=1) + price
        best[better], left[better], price[better] = there[better], found[better], costs[better]
        damped *= np.where(better, LESS, MORE)
    gains = 0.5 * (before - (left ** 2).sum(axis=1) - price) >= LEAST
    return _at(uses, np.array(joints)[gains].tolist(), best[gains], peaks)


def _free(uses, j, peak):
    """Return which (5,) of joint j's coordinates settle: of a peak what has been told of it."""
    told = _use(uses, PEAK, j).told_shape if peak else ()
    return [True, True, *(name in told for name in (
        'stribeck_velocity', 'exponent', 'velocity_range'))]


def _residuals(system, uses, evidence, x, weights, joints):
    """Return what is left (J, N) of joints with their own effects fitted again."""
    return np.array(list(joint_residuals(uses, System(system.robot, uses, evidence, x), x,
                                         weights, joints)))


def _slopes(left_at, best, left, free):
    """Return slopes (J, N, 5) of what is left (J, N) per step, away from the nearer end."""
    slopes = np.zeros((*left.shape, best.shape[1]))
    for k, step in enumerate(STEPS):
        if free[:, k].any():
            sign = np.where(best[:, k] + step > MOST_PLACE[k], -1.0, 1.0)
            beside = best.copy()
            beside[:, k] += sign * step
            slopes[..., k] = sign[:, None] * (left_at(beside) - left)
    return slopes


def _steps(slopes, left, free, damped):
    """Return the damped steps (J, 5) of Gauss and Newton (Levenberg 1944)."""
    out = np.zeros((len(left), len(STEPS)))
    for j, own in enumerate(free):
        matrix = slopes[j][:, own]
        square = matrix.T @ matrix
        square[np.diag_indices_from(square)] *= 1.0 + damped[j]
        out[j, own] = -STEPS[own] * np.linalg.lstsq(square, matrix.T @ left[j], rcond=1e-9)[0]
    return out


def _use(uses, name, j):
    return next((u for u in uses if (u.name, u.joint) == (name, j)), None)


def _place(uses, j):
    """Return joint j's place (5,): the logarithm of its travel, ... as of STEPS."""
    shape, peak = _use(uses, PRESLIDING, j).shape, _use(uses, PEAK, j)
    own = (0.0, 1.0, 0.0) if peak is None else (
        np.log(peak.shape['stribeck_velocity']), peak.shape['exponent'],
        1.0 / peak.shape['velocity_range'])
    return np.clip([np.log(shape[TRAVEL]), shape[PLASTIC.name], *own], LEAST_PLACE, MOST_PLACE)


def _at(uses, joints, places, peaks):
    """Return uses with other places (J, 5) of joints."""
    shapes = {}
    for j, (travel, plastic, velocity, exponent, gain) in zip(joints, places.tolist()):
        shapes[PRESLIDING, j] = {TRAVEL: float(np.exp(travel)), PLASTIC.name: plastic}
        if j in peaks:
            shapes[PEAK, j] = {
                'stribeck_velocity': float(np.exp(velocity)), 'exponent': exponent,
                'velocity_range': 1.0 / gain if gain else np.inf, OWN_TRAVEL.name: np.inf,
                PLASTIC.name: BOTH}
    return tuple(replace(u, shape={**u.shape, **shapes[u.name, u.joint]}, shape_std={})
                 if (u.name, u.joint) in shapes else u for u in uses)
