"""
The zero of one joint moved since the model was made: no link has changed, and many seem to.

After a joint or an encoder was replaced, or the arm was mastered anew, angles are off by a
constant. The model then sees every link behind that joint, and the springs at it, in other places
than they are, which other links or springs imitate figure by figure. One angle explains it all.
"""

from dataclasses import replace

import numpy as np

from ...effects import LINK_INERTIA
from ..diagnosis import CONFIRMED, SUSPECTED
from ..tracing.candidate import significant, single
from ..tracing.confusable import CLOSE
from ..tracing.hypothesis import beside_delays, Hypothesis

# What a zero elsewhere looks like.
IMITATED = (LINK_INERTIA.name, 'gravity_spring', 'base_tilt')
SCALE = 0.01  # [rad]
_STEP = 1e-4  # [rad] of the derivative


def moved_zero(findings, model, trace):
    """
    Return (Findings, sentence or '', sentences): suspected is what one joint's zero explains too.

    trace: a finished Trace of a Residual of the TorqueModel. Each joint's zero is one figure,
    asked in the place of all links, springs and leaning bases that were found. The first sentence
    is the result, the others say what is suspected for it.
    """
    steps = [step for step in trace.steps if step.chosen.name in IMITATED]
    doubted = [f.verdict == CONFIRMED and f.name in IMITATED for f in findings]
    if not steps or not any(doubted):
        return findings, '', ()
    blocks, named = trace.beside(*steps), trace.beside()
    gained = sum(float((blocks.misfit(i) - named.misfit(i)).sum()) for i in range(model.robot.n))
    best = max((single(zero, blocks.evaluate(zero.columns))
                for zero in _zeros(model, trace.residual)), key=lambda c: c.gain)
    if best.gain < CLOSE * gained or not significant(best):
        return findings, '', ()
    joint = model.robot.joints[best.joints[0]]
    # A base leans by two figures: of one against two nobody can say that it is rather the one.
    only_leans = {f.name for f, d in zip(findings, doubted) if d} == {'base_tilt'}
    return (tuple(replace(f, verdict=SUSPECTED) if d else f for f, d in zip(findings, doubted)),
            '' if only_leans else
            f'Rather the zero of {joint} has moved than anything else that is suspected: its '
            f'angle is recorded {_told(best)} rad from where it was. Correct it (mastering, '
            f'encoder), or identify {model.robot.name} anew',
            tuple(f'{", ".join(f.joints)}: {f.name} is only suspected, because the angle of '
                  f'{joint}, off by a constant, explains as much with one figure'
                  for f, d in zip(findings, doubted) if d))


def _told(zero):
    """Return the angle [rad] of a Candidate, with two standard deviations."""
    (_, score), = zero.parts
    return f'{SCALE * score.theta[0]:+.4f} ± {2.0 * SCALE * score.covariance[0, 0] ** 0.5:.2g}'


def _zeros(model, residual):
    """Yield the Hypothesis of each moving joint's angle that is recorded too large."""
    robot, x = model.robot, residual.x
    links = [_carried(model, load) for load in residual.loads]
    for j in np.flatnonzero(residual.weights.any(axis=0)).tolist():
        step = _STEP * (np.arange(robot.n) == j)
        columns = np.array([_slope(robot, links[part], q, v, a, step) for q, v, a, part in
                            zip(x.q, x.v, x.a, residual.owner)])
        # Where the angle is too large the arm is still where the torque is from.
        yield beside_delays(Hypothesis('moved_zero', j, {
            i: -SCALE * columns[:, i, None] for i in range(robot.n)}, np.array([SCALE])), residual)


def _carried(model, load):
    """Return the products (10 n,) of the links, the last of which holds a load known or None."""
    links = model.mean[:model.layout.links].copy()
    if load is not None:
        links[-10:] += model.robot.in_last_link(load.to_products())
    return links


def _slope(robot, links, q, v, a, step):
    """Return the derivative (n,) of the links' torque along a step (n,) of the angles."""
    ahead, behind = (robot.link_regressor(q + way * step, v, a) @ links for way in (1.0, -1.0))
    return (ahead - behind) / (2.0 * _STEP)
