"""
Whether a plain function tells a joint's residual better than all that is named there.

An effect outside the vocabulary is imitated by what is in it: friction with a peak in speed looks
like some that grows with speed, as far as most motions reach, and beside that like nothing. So
where named effects leave most of what there was, a function is asked in their place.
"""

from dataclasses import dataclass

import numpy as np

from ...effects import LATE
from ..diagnosis import Evidence, UNKNOWN
from ..tracing.candidate import Candidate, evaluated, significant, single, standard_error
from ..tracing.plain_functions import functions_judged
from ..tracing.trace import UNKNOWN_FACTOR


@dataclass(frozen=True)
class FunctionLeft:
    """A variable, the Evidence in the rows judged, the share of their mean square explained."""

    variable: str
    evidence: Evidence
    explained: float


def function_left(robot, trace, j):
    """
    Return the FunctionLeft of joint j in the place of its named effects, or None.

    It surely gains, and surely more than they do, where both can be judged. None, too, where
    nothing is named, which the trace has asked, and where a delay is, which delays all the rest.
    """
    own = [step for step in trace.steps if step.chosen.touched == [j]]
    late = any(step.chosen.name == LATE and j in step.chosen.touched
               for step in (*trace.steps, *trace.drifted))
    if not own or late:
        return None
    blocks, named = trace.beside(*own), trace.beside()
    found = [_judged(trace, blocks, named, own, *function) for function in functions_judged(
        trace.residual, blocks, robot.limits.torque, j)]
    return max(filter(None, found), key=lambda f: f.evidence.gain, default=None)


def _judged(trace, blocks, named, own, function, rows):
    """Return the FunctionLeft of one function beside Blocks without and with own, or None."""
    j = function.joint
    blocks, named = blocks.only(j, rows), named.only(j, rows)
    candidate = single(function, blocks.evaluate(function.columns))
    more = candidate.by_block - (blocks.misfit(j) - named.misfit(j))
    ahead = Candidate(UNKNOWN, candidate.parts, float(more.sum()), standard_error(more), more)
    needed = UNKNOWN_FACTOR * trace.needed
    if min(candidate.gain, ahead.gain) < needed or not trace.matters(candidate) \
            or not (significant(candidate) and significant(ahead)):
        return None
    rival = max((evaluated(step.chosen, blocks) for step in own), key=lambda c: c.gain)
    without, torque = blocks.left_over(j), candidate.torque(blocks.residual.shape[1])[:, j]
    after = blocks.left_over(j, torque) - torque
    return FunctionLeft(
        function.variable,
        Evidence(candidate.gain, candidate.std, needed, len(more), trace.trials, np.nan,
                 rival.name, ahead.gain),
        float(1.0 - (after[rows] ** 2).sum() / (without[rows] ** 2).sum()))
