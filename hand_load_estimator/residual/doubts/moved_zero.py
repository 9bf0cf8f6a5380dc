"""
The zero of one joint moved since the model was made: no link has changed, and many seem to.

After a joint or an encoder was replaced, or the arm was mastered anew, angles are off by a
constant. The model then sees every link behind that joint, and what pulls at it, in other places
than they are, which other links, springs or a leaning base imitate figure by figure. One angle
explains it all.
"""

from dataclasses import replace

import numpy as np

from ...effects import EffectInput, LINK_INERTIA
from ...torque.columns import torque_columns
from ..diagnosis import CONFIRMED, SUSPECTED
from ..tracing.candidate import Candidate, significant, single, standard_error
from ..tracing.confusable import CLOSE
from ..tracing.hypothesis import beside_delays, Hypothesis

# What a zero elsewhere looks like.
IMITATED = (LINK_INERTIA.name, 'gravity_spring', 'base_tilt')
SCALE = 0.01  # [rad]
LIFTS = 1e-3  # [-] of its torque limit, above which the first joint carries weight
# The secant from no angle to the one found so far, so many times: large angles bend the torque.
_SECANTS = 3


def moved_zero(findings, model, trace):
    """
    Return (Findings, sentence or '', sentences): suspected is what one joint's zero explains too.

    trace: a finished Trace of a Residual of the TorqueModel. Each joint's zero is one figure,
    asked in the place of all links, springs and leaning bases that were found. The first sentence
    is the result, the others say what is suspected for it.
    """
    steps = [step for step in trace.steps if step.chosen.name in IMITATED]
    if not steps:
        return findings, '', ()
    blocks, named = trace.beside(*steps), trace.beside()
    gained = sum(blocks.misfit(i) - named.misfit(i) for i in range(model.robot.n))
    zero = _best_zero(model, trace.residual, blocks)
    if not _as_good(zero, gained):
        return findings, '', ()
    doubted = [f.verdict == CONFIRMED and f.name in IMITATED for f in findings]
    joint, angle = model.robot.joints[zero.joints[0]], _angle(zero)
    return (tuple(replace(f, verdict=SUSPECTED) if d else f for f, d in zip(findings, doubted)),
            _result(model.robot, joint, angle) if zero.gain >= gained.sum() else '',
            tuple(f'{", ".join(f.joints)}: {f.name} is only suspected, because the angle of '
                  f'{joint}, recorded {angle} rad from where it was, explains as much with one '
                  'figure' for f, d in zip(findings, doubted) if d))


def _result(robot, joint, angle):
    """Return what happened in a sentence."""
    # Turned about the last axis the hand turns too, and nothing tells one from the other.
    held = ', or what the hand holds sits turned about it' * (joint == robot.joints[-1])
    # Turned about the first axis, where that is not upright, the whole arm leans.
    if joint == robot.joints[0] and _first_joint_lifts(robot):
        held += ', or the base is mounted turned about it'
    return (f'The zero of {joint} seems to have moved, and nothing else that is suspected: its '
            f'angle is recorded {angle} rad from where it was{held}. Correct it (mastering, '
            f'encoder), or identify {robot.name} anew')


def _first_joint_lifts(robot):
    """Tell whether the first joint carries weight, as that of no upright arm does."""
    rng, rest = np.random.default_rng(0), np.zeros(robot.n)
    weight = [robot.rigid_torque(rng.uniform(-2.0, 2.0, robot.n), rest, rest)[0]
              for _ in range(10)]
    return bool(np.abs(weight).max() > LIFTS * robot.limits.torque[0])


def _angle(zero):
    """Return the angle [rad] of a Candidate, with two standard deviations."""
    (_, score), = zero.parts
    return f'{SCALE * score.theta[0]:+.4f} ± {2.0 * SCALE * score.covariance[0, 0] ** 0.5:.2g}'


def _as_good(zero, gained):
    """Tell whether blocks (G,) do not surely gain more by what was found than by a Candidate."""
    more = gained - zero.by_block
    ahead = Candidate('', (), float(more.sum()), standard_error(more), more)
    return significant(zero) and zero.gain > CLOSE * gained.sum() and not significant(ahead)


def _best_zero(model, residual, blocks):
    """Return the Candidate of the joint's zero that gains most on Blocks."""
    now = _torque(model, residual, residual.x.q)

    def moved(j, angle):
        changed = _torque(model, residual, residual.x.q - angle * (np.arange(model.robot.n) == j))
        # Where the angle is recorded too large the arm is still where the torque is from.
        columns = SCALE * (changed - now) / angle
        hypothesis = beside_delays(Hypothesis('moved_zero', j, {
            i: columns[:, i, None] for i in range(model.robot.n)}, np.array([SCALE])), residual)
        return single(hypothesis, blocks.evaluate(hypothesis.columns))
    moving = np.flatnonzero(residual.weights.any(axis=0)).tolist()
    best = max((moved(j, SCALE) for j in moving), key=lambda c: c.gain)
    for _ in range(_SECANTS):
        angle = SCALE * float(best.parts[0][1].theta[0])
        if angle != 0.0:
            best = moved(best.joints[0], angle)
    return best


def _torque(model, residual, q):
    """Return the model's torque (N, n) at positions q (N, n), with the loads that are known."""
    out = np.empty_like(q)
    for part, load in enumerate(residual.loads):
        own, mean = residual.owner == part, model.mean.copy()
        mean[:model.layout.links][-10:] += model.robot.in_last_link(load.to_products())
        x = EffectInput(q[own], *(getattr(residual.x, name)[own]
                                  for name in ('v', 'a', 'warmth', 'z')))
        out[own] = torque_columns(model.robot, model.layout, x, mean) @ mean
    return out
