"""Add what was found: a torque model with the new effects, everything in it estimated together."""

from dataclasses import replace

import numpy as np

from ..identification import System, density, held_out, prior, rmse_of
from ..torque_model import Residuals, TorqueModel
from .diagnosis import UNKNOWN
from .hypotheses import EFFECT_FACTOR, with_effect

# What is known of the arm from before stays known, with standard deviations so much wider.
WIDER = 3.0


def better_model(model, steps, evidence):
    """
    Return the TorqueModel with the effects of steps, identified from Evidence.

    The old model's mean and covariance are the prior (eq. 11), except where the recordings are
    those it was made from: then the robot file's. An `unknown` effect adds nothing.
    """
    uses = model.uses
    changed = set()
    for step in steps:
        for hypothesis, _ in step.chosen.parts:
            if hypothesis.name in (UNKNOWN, 'link_inertia'):
                changed.add((hypothesis.name, hypothesis.joint))
                continue
            uses = with_effect(replace(model, uses=uses), hypothesis)
            changed.add((hypothesis.name, hypothesis.joint))
    mean, covariance = _prior(model, uses, changed, {e.name for e in evidence})
    return _identified(model, uses, mean, covariance, evidence)


def _prior(model, uses, changed, names):
    robot = model.robot
    links = model.links_declared or any(name == 'link_inertia' for name, _ in changed)
    first, wide = prior(robot, uses, links)
    if names & set(model.recordings):
        return first, wide
    mean, covariance = first.copy(), np.zeros_like(wide)
    old = {(use.name, use.joint): where for use, where in model.slices()}
    rows, places = list(range(10 * robot.n)), list(range(10 * robot.n))
    new = TorqueModel(robot, uses, links, first, wide, model.residuals)
    for use, where in new.slices():
        if (use.name, use.joint) in old:
            rows += range(where.start, where.stop)
            before = old[use.name, use.joint]
            places += range(before.start, before.stop)
    mean[rows] = model.mean[places]
    covariance[np.ix_(rows, rows)] = WIDER ** 2 * model.covariance[np.ix_(places, places)]
    wide = np.diag(wide)
    for use, where in new.slices():
        free = (use.name, use.joint) in changed or (use.name, use.joint) not in old
        if free:
            covariance[where, where] += np.diag(EFFECT_FACTOR ** 2 * wide[where])
    for name, joint in changed:
        if name == 'link_inertia':
            where = slice(10 * joint, 10 * joint + 10)
            covariance[where, where] += np.diag(EFFECT_FACTOR ** 2 * wide[where])
    return mean, covariance


def _identified(model, uses, mean, covariance, evidence):
    robot, x, residuals = model.robot, mean, model.residuals
    intensity, friction = residuals.intensity, model.friction_level()
    for _ in range(3):
        system = System(robot, uses, evidence, x)
        weights = system.weights(intensity, friction)
        x, posterior = system.solve(mean, covariance, weights)
        friction = TorqueModel(robot, uses, True, x, posterior, None).friction_level()
        left_out = held_out(system, mean, covariance, weights)
        # A short recording does not show all that the arm did before.
        intensity = np.maximum(density(left_out, weights, system.owner, system.dt),
                               0.5 * residuals.intensity)
    found = Residuals(np.maximum(rmse_of(robot, system, left_out), 0.7 * residuals.rmse),
                      intensity, residuals.drift)
    seen = np.concatenate([e.motion.temperature.ravel() for e in evidence])
    seen = seen[np.isfinite(seen)]
    temperatures = [t for t in (model.temperatures, (seen.min(), seen.max()) if len(seen) else None)
                    if t is not None]
    names = tuple(dict.fromkeys((*model.recordings, *(e.name for e in evidence))))
    return TorqueModel(robot, uses, True, x, posterior, found, names,
                       (float(min(t[0] for t in temperatures)),
                        float(max(t[1] for t in temperatures))) if temperatures else None)
