"""Search of the nonlinear shapes of declared effects: the value that fits a joint best."""

from dataclasses import replace
from itertools import product

import numpy as np

from ..effects import EFFECTS, PRESLIDING
from ..torque.columns import effect_slices
from ..torque.contact_level import contact_level
from ..torque.motion_inputs import motion_inputs
from .regression_system import System, ways_to_turn

TRAVEL = 'presliding_distance'
# Travels to look at around one that was found, in times it.
AROUND = (1.0, 0.75, 0.87, 1.15, 1.33)
# Nats that another value than the default must gain, instead of what a Shape asks for: how
# friction turns is looked for where it turns, and shows there.
PRICES = {'plastic': 1.0}
# Nats that a travel must gain to be e times as long. Where recordings do not tell it, chance would
# take a long one, which excuses more samples from the fit: friction is then off while it turns.
EXCUSED = 2.0


def search_shapes(robot, uses, evidence, x, intensity, friction, again=False):
    """
    Return uses with each joint's shapes set to the values that fit its residual best.

    again: of presliding travels, only those around the ones found already.
    """
    uses = list(uses)
    # The same weights for every trial: a longer presliding travel would excuse more samples.
    first = System(robot, tuple(uses), evidence, x)
    weights, turning = first.weights(intensity, friction), first.turning_weights(intensity)
    for name, shapes in _shapes_of(uses):
        # How friction turns shows where it does, which tells little of anything else.
        counts = turning if name == PRESLIDING else weights
        around = again and name == PRESLIDING
        tried = list(_around(uses) if around else _grid(uses, name, shapes))
        best = {}
        for trial, system in _systems(robot, uses, tried, evidence, x, name):
            # Where nothing tells, a shape stays.
            own = {use.joint: use for use in trial
                   if use.name == name and counts[:, use.joint].any()}
            costs = joint_costs(trial, system, x, counts, range(robot.n))
            for j, cost in enumerate(costs):
                if j in own:
                    # Twice the nats that the values must gain over defaults.
                    cost += 2.0 * sum(_price(shape, own[j].shape) for shape in shapes)
                    best[j] = min(best.get(j, (np.inf,)), (cost, own[j]), key=lambda one: one[0])
        uses = [best[use.joint][1] if use.name == name and use.joint in best else use
                for use in uses]
    return tuple(uses)


def _grid(uses, name, shapes):
    """Yield uses with each combination of the values of an effect's Shapes, on all joints."""
    for values in product(*(shape.grid for shape in shapes)):
        new = {shape.name: value for shape, value in zip(shapes, values)}
        yield tuple(replace(u, shape={**u.shape, **new}) if u.name == name else u for u in uses)


def _around(uses):
    """Yield uses with travels around their own, of contacts that yield as theirs and otherwise."""
    for other, factor in product((False, True), AROUND):
        yield tuple(replace(u, shape=_near(u, other, factor)) if u.name == PRESLIDING else u
                    for u in uses)


def _near(use, other, factor):
    plastic = use.shape['plastic']
    plain, sprung = next(s.grid for s in use.effect.shapes if s.name == 'plastic')
    if other:
        plastic = sprung if plastic == plain else plain
    return {**use.shape, TRAVEL: factor * use.shape[TRAVEL], 'plastic': plastic}


def _systems(robot, uses, tried, evidence, x, name):
    """
    Yield (uses, their System) of tuples of uses that differ in an effect's shapes.

    uses: as they are, which x (P,) is of: with another knee these slopes would foretell travels
    that no joint has.
    """
    ways = [ways_to_turn(robot.n, trial) for trial in (tried if name == PRESLIDING else [uses])]
    inputs = motion_inputs(robot, [e.motion for e in evidence], ways,
                           contact_level(robot, uses, x))
    if name == PRESLIDING:
        for trial, given in zip(tried, inputs):
            yield trial, System(robot, trial, evidence, x, given)
        return
    alone, system, given = EFFECTS[name].needs <= {'warmth'}, None, next(inputs)
    for trial in tried:
        if system is None or not alone:
            system = System(robot, trial, evidence, x, given)
        else:
            for use, where in effect_slices(robot.n, trial):
                if use.name == name:
                    system.reshape(use, where)
        yield trial, system


def _price(shape, values):
    """Return the nats that a value of a Shape must gain beyond the default, or the shortest."""
    if shape.name == TRAVEL:
        return EXCUSED * max(np.log(values[TRAVEL] / shape.grid[0]), 0.0)
    return 0.0 if values[shape.name] == shape.default else PRICES.get(shape.name, shape.gain)


def _shapes_of(uses):
    """Return (effect name, Shapes to search together) pairs, presliding first: it changes z."""
    seen = {(u.name, s.name): s for u in uses for s in u.effect.shapes if len(s.grid) > 1}
    turning = tuple(s for (name, _), s in seen.items() if name == PRESLIDING)
    return [*([(PRESLIDING, turning)] if turning else []),
            *((name, (s,)) for (name, _), s in seen.items() if name != PRESLIDING)]


def joint_costs(uses, system, x, weights, joints):
    """Yield the sum of squares of joint_residuals."""
    for left in joint_residuals(uses, system, x, weights, joints):
        yield float(np.sum(left ** 2))


def joint_residuals(uses, system, x, weights, joints):
    """
    Yield the weighted residual (N,) of each of joints with its own effects refitted.

    system: of uses; x (P,): of all else; weights (N, n).
    """
    n = system.robot.n
    for j in joints:
        own = [w for u, w in effect_slices(n, uses) if u.joint == j]
        if not own:
            yield np.zeros(len(weights))
            continue
        index = np.concatenate([np.arange(w.start, w.stop) for w in own])
        y = system.columns[:, j, :]
        others = x.copy()
        others[index] = 0.0
        target = system.torque[:, j] - y @ others
        root = np.sqrt(weights[:, j])
        matrix = y[:, index] * root[:, None]
        scale = np.linalg.norm(matrix, axis=0) + 1e-12
        solution, *_ = np.linalg.lstsq(matrix / scale, target * root, rcond=1e-8)
        yield target * root - matrix / scale @ solution
