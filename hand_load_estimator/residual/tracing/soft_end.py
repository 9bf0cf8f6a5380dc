"""
Whether what was found may be an effort that ends softly.

Where the bend of such an effort is small, or friction is most of the torque, no function of torque
is found beside the gain that comes nearest (saturating.py), and friction makes up for the rest. So
the gain of a joint is compared with soft ends in its place, and what else was found there is asked
again beside these. A gain that joints have alike is one: drives of several sizes do not saturate
by the same share.
"""

import numpy as np

from ...effects import LATE
from ..diagnosis import UNKNOWN
from .candidate import ahead, evaluated, joined, significant, single
from .hypothesis import beside_delays, Hypothesis
from .saturating import GAIN

# Where an effort may end softly, in times the largest torque that the joint has shown. What ends
# farther off bends as the last of these does.
ENDS = (0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 2.0)
# An effort that ends within what the joint has shown falls behind by this share of the formula, or
# more: less of it is a gain, beside other friction. Beyond, the formula has one form in any
# amount, also below zero: a motor whose torque falls behind its current.
LEAST = 0.3


def own_gains(steps):
    """Return the Steps of gains that joints have by themselves."""
    return [step for step in steps if step.chosen.name == GAIN and not step.chosen.common]


def soft_ends(found, known):
    """
    Return {joint index: Candidates} of the soft ends that a gain Found is not surely more than.

    A Candidate is e tanh(torque / e) - torque in some amount; torque: the drive's. known: indices
    of the joints that are known to saturate.
    """
    ends = {}
    for step in own_gains(found.steps):
        blocks = found.without(step)
        for gain in (h for h, _ in step.chosen.parts if h.joint not in known):
            as_good = _as_good(gain, blocks, found.residual)
            if as_good:
                ends[gain.joint] = as_good
    return ends


def _as_good(gain, blocks, residual):
    """Return the Candidates of soft ends that a Hypothesis of a gain is not surely more than."""
    there, as_good = single(gain, blocks.evaluate(gain.columns)), []
    for times in ENDS:
        hypothesis = _soft_end(gain.joint, times, residual)
        score = blocks.evaluate(hypothesis.columns)
        end = single(hypothesis, score)
        if (score.theta[0] > LEAST or times >= 1.0) and not significant(ahead(there, end)):
            as_good.append(end)
    return as_good


def _soft_end(j, times, residual):
    """Return the Hypothesis `unknown` of joint j whose effort ends at one of ENDS."""
    torque = residual.x.drive[:, j]
    end = times * np.abs(torque[residual.weights[:, j] > 0.0]).max()
    columns = (end * np.tanh(torque / end) - torque)[:, None]
    return beside_delays(Hypothesis(UNKNOWN, j, {j: columns}, np.ones(1),
                                    variable='drive torque'), residual)


def may_be_soft_end(step, ends, found):
    """
    Tell whether a Step of Found is a gain of soft_ends, or gains nothing sure beside one of them.

    What gains beside the gain only makes up for what that leaves of a soft end.
    """
    if step.chosen.name in (UNKNOWN, LATE):
        return False
    if any(step is gain for gain in own_gains(found.steps)):
        return ends.keys() >= set(step.chosen.joints)
    return any(_needless(step, j, ends[j], found) for j in step.chosen.touched if j in ends)


def _needless(step, j, ends, found):
    """Tell whether a Step gains nothing sure at joint j beside one of the soft ends there."""
    (gain,) = (own for own in own_gains(found.steps) if j in own.chosen.joints)
    blocks = found.beside(step, gain)
    for hypothesis, _ in gain.chosen.parts:
        if hypothesis.joint != j:
            blocks.add(hypothesis.columns)
    own = [part for part in step.chosen.parts if part[0].joint == j]
    asked = joined(step.chosen.name, tuple(own)) if own and not step.chosen.common else step.chosen
    for end in ends:
        again = evaluated(asked, blocks.beside(end.columns))
        if again.gain < step.needed or not significant(again):
            return True
    return False


def soft_end_doubts(findings, trace):
    """Return a sentence on each of Findings of a Trace's steps that may be a soft end."""
    return tuple(
        f'{", ".join(finding.joints)}: {finding.name} is only suspected, because ' + (
            'an effort that ends softly is not surely told from it' if finding.name == GAIN else
            'beside an effort that ends softly it gains nothing sure')
        for finding, step in zip(findings, trace.steps)
        if any(step is doubted for doubted in trace.maybe_soft_ends))
