"""Search of the nonlinear shapes of declared effects: the grid value that fits a joint best."""

from dataclasses import replace

import numpy as np

from ..effects import EFFECTS
from ..torque.columns import effect_slices
from .regression_system import System


def search_shapes(robot, uses, evidence, x, intensity, friction):
    """Return uses with each joint's shapes set to the values that fit its residual best."""
    uses = list(uses)
    # The same weights for every trial: a longer presliding travel would excuse more samples.
    weights = System(robot, tuple(uses), evidence, x).weights(intensity, friction)
    for name, shape in _shapes_of(uses):
        best = {}
        for value, trial, system in _trials(robot, uses, evidence, x, name, shape):
            for j, cost in enumerate(_joint_costs(robot, trial, system, x, weights)):
                # Twice the nats that the value must gain over the first, which is the default.
                if j not in best or cost < best[j][0] - 2.0 * _price(shape, best[j][1]):
                    best[j] = (cost, value)
        uses = [replace(u, shape={**u.shape, shape.name: best[u.joint][1]})
                if u.name == name else u for u in uses]
    return tuple(uses)


def _trials(robot, uses, evidence, x, name, shape):
    """Yield (value, uses with it on all joints, their System) for the grid of a Shape."""
    alone = name != 'presliding_hysteresis' and EFFECTS[name].needs <= {'warmth'}
    system = System(robot, tuple(uses), evidence, x) if alone else None
    for value in shape.grid:
        trial = tuple(replace(u, shape={**u.shape, shape.name: value})
                      if u.name == name else u for u in uses)
        if not alone:
            system = System(robot, trial, evidence, x)
        for use, where in effect_slices(robot.n, trial) if alone else ():
            if use.name == name:
                system.reshape(use, where)
        yield value, trial, system


def _price(shape, value):
    """Return the nats that another value of a Shape must gain beyond this one."""
    return shape.gain if value == shape.default else 0.0


def _shapes_of(uses):
    """Return the different (effect name, Shape) pairs, presliding first: it changes z."""
    seen = {(u.name, s.name): (u.name, s)
            for u in uses for s in u.effect.shapes if len(s.grid) > 1}
    return sorted(seen.values(), key=lambda pair: pair[0] != 'presliding_hysteresis')


def _joint_costs(robot, uses, system, x, weights):
    """Return each joint's weighted squared residual with its own effects refitted."""
    start = 10 * robot.n
    for j in range(robot.n):
        own = [w for u, w in effect_slices(robot.n, uses) if u.joint == j]
        if not own:
            yield 0.0
            continue
        index = np.concatenate([np.arange(w.start, w.stop) for w in own])
        y = system.columns[:, j, :]
        target = system.torque[:, j] - y[:, :start] @ x[:start]
        root = np.sqrt(weights[:, j])
        matrix = y[:, index] * root[:, None]
        scale = np.linalg.norm(matrix, axis=0) + 1e-12
        solution, *_ = np.linalg.lstsq(matrix / scale, target * root, rcond=1e-8)
        yield float(np.sum((target * root - matrix / scale @ solution) ** 2))
