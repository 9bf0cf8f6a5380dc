"""
How a joint's friction turns, settled beside everything else of the joint.

A search beside a model that stays as it is sees only what Coulomb friction does in another way of
turning. What else turns with it, and how far its figures are off by then, moves the best way by
more than it is known by.
"""

from dataclasses import replace

import numpy as np

from ..effects import EFFECTS, PRESLIDING
from ..effects.own_travel import BOTH, PLASTIC
from ..torque.motion_inputs import motion_inputs
from ..torque.travel_growth import travel_growth
from .regression_system import System, ways_to_turn
from .shape_search import joint_costs, PRICES, TRAVEL

TURNS = 4
# Steps of a turn in the logarithm of the travel and in the way over which contacts yield, in
# levels; each turn's are SMALLER.
STEPS, SMALLER = np.array([0.08, 0.3]), 0.5
# No turn goes further than so many steps.
FURTHEST = 2.0
# [nats] that settling must gain: noise moves a way by less.
LEAST = 5.0


def with_turning_fitted(system, uses, evidence, x, intensity, joints):
    """
    Return uses whose joints (indices) turn as all effects of each fit best.

    system: the System of uses and Evidence; x (P,): tells the torque of all else; intensity (n,)
    [Nm^2 s] of the residual. Where that gains less than LEAST nothing changes.
    """
    joints = [j for j in joints if any((u.name, u.joint) == (PRESLIDING, j) for u in uses)]
    if not joints:
        return uses
    robot, weights = system.robot, system.turning_weights(intensity)
    growth = travel_growth(robot, uses, x)

    def costs_at(places):
        """Return costs (K, J) of ways of turning (K, J, 2)."""
        trials = [_turning(uses, joints, those) for those in places]
        inputs = motion_inputs(robot, [e.motion for e in evidence],
                               [ways_to_turn(robot.n, trial) for trial in trials], growth)
        # Twice the nats that a spring must gain.
        prices = 2.0 * PRICES[PLASTIC.name] * (places[..., 1] < BOTH)
        return prices + np.array([
            list(joint_costs(trial, System(robot, trial, evidence, x, given), x, weights, joints))
            for trial, given in zip(trials, inputs)])
    best = np.array([_place(uses, j) for j in joints])
    before = least = costs_at(best[None])[0]
    steps = STEPS
    for _ in range(TURNS):
        axes = np.concatenate([np.diag(steps), -np.diag(steps)])[:, None]
        around = _possible(best + axes)
        found = costs_at(around)
        further = _possible(best + steps * _bottoms(found[:2], least, found[2:]).T)
        tried = np.concatenate([best[None], around, further[None]])
        costs = np.concatenate([least[None], found, costs_at(further[None])])
        which = costs.argmin(axis=0)
        best, least = tried[which, np.arange(len(joints))], costs.min(axis=0)
        steps = SMALLER * steps
    gains = 0.5 * (before - least) >= LEAST
    return _turning(uses, np.array(joints)[gains].tolist(), best[gains])


def _bottoms(above, here, below):
    """Return in steps how far (2, J) parabolas through costs (2, J), (J,) have their least."""
    bend = above + below - 2.0 * here
    return np.clip(0.5 * (below - above) / np.maximum(bend, 1e-9), -FURTHEST, FURTHEST)


def _possible(places):
    """Return places (..., 2) at which contacts yield over as much as they may."""
    places[..., 1] = np.clip(places[..., 1], PLASTIC.least, PLASTIC.most)
    return places


def _place(uses, j):
    """Return the logarithm of joint j's travel [rad], and over which way its contacts yield."""
    shape = next(u.shape for u in uses if (u.name, u.joint) == (PRESLIDING, j))
    return np.log(shape[TRAVEL]), shape[PLASTIC.name]


def _turning(uses, joints, places):
    """Return uses with other places (J, 2) of joints."""
    shapes = {j: EFFECTS[PRESLIDING].bounded({
        TRAVEL: float(np.exp(travel)), PLASTIC.name: float(plastic)})
        for j, (travel, plastic) in zip(joints, places)}
    return tuple(replace(u, shape={**u.shape, **shapes[u.joint]}, shape_std={})
                 if u.name == PRESLIDING and u.joint in shapes else u for u in uses)
