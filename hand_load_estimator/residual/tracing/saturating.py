"""
Whether a gain is one, or a drive that saturates.

A wrong torque constant leaves nothing that follows torque. An effort that ends softly, or a motor
whose torque falls behind its current, looks like a gain first; what is left is then taken for a
cable, friction or whatever follows torque by chance, though a plain function of torque tells more.
Where it is little, or friction is most of the torque, no such function is found: there the gain
itself is compared with efforts that end softly, which have as few parameters.
"""

import numpy as np

from ..diagnosis import SUSPECTED, UNKNOWN
from .candidate import ahead, significant, single
from .hypothesis import beside_delays, Hypothesis
from .plain_functions import TORQUES

GAIN = 'torque_scale'
# A function of torque whose bend moves more than this share of what the gain does speaks against
# it: a tanh has a quarter or more, and less only where the torque never changes its sign.
SATURATES = 0.2
# Where an effort may end softly, in times the largest torque that the joint has shown: what ends
# farther off bends as the last of these, what ends sooner is nearly a gain.
ENDS = (0.5, 1.0, 2.0)


def gain_beside(candidate, steps):
    """Return the Candidate of a gain among Steps that another, `unknown` of torque, is beside."""
    if candidate.name != UNKNOWN or candidate.variable not in TORQUES:
        return None
    return next((step.chosen for step in steps if step.chosen.name == GAIN
                 and set(candidate.joints) <= set(step.chosen.joints)), None)


def saturates(candidate, steps, n):
    """Tell whether a Candidate speaks against the gain that it is beside; n joints."""
    gain = gain_beside(candidate, steps)
    if gain is None:
        return False
    j, = candidate.joints
    function, linear = (c.torque(n)[:, j] for c in (candidate, gain))
    # Beside the gain a function has some of its slope: only what is no gain speaks against one.
    bend = function - linear * (linear @ function) / (linear @ linear)
    return bool(np.linalg.norm(bend) > SATURATES * np.linalg.norm(linear))


def saturating(steps, n):
    """Return the indices of the joints whose gain an `unknown` among Steps speaks against."""
    return {step.chosen.joints[0] for step in steps
            if step.chosen.name == UNKNOWN and saturates(step.chosen, steps, n)}


def as_well_softly(steps, without, residual):
    """
    Return the indices of joints at which an effort that ends softly may explain what a gain does.

    without(step): Blocks without one of Steps; residual: Residual. A gain that several joints
    have alike is one: no drives saturate all by the same share.
    """
    return {hypothesis.joint for step in steps
            if step.chosen.name == GAIN and not step.chosen.common
            for blocks in [without(step)] for hypothesis, _ in step.chosen.parts
            if not _surely_a_gain(hypothesis, blocks, residual)}


def _surely_a_gain(hypothesis, blocks, residual):
    gain, *ends = (single(h, blocks.evaluate(h.columns))
                   for h in (hypothesis, *_ends(hypothesis.joint, residual)))
    return significant(ahead(gain, max(ends, key=lambda end: end.gain)))


def _ends(j, residual):
    """Yield Hypotheses `unknown` of joint j whose effort ends softly at some of ENDS."""
    torque = residual.x.drive[:, j]
    for end in np.abs(torque).max() * np.array(ENDS):
        columns = (end * np.tanh(torque / end) - torque)[:, None]
        yield beside_delays(Hypothesis(UNKNOWN, j, {j: columns}, np.ones(1),
                                       variable='drive torque'), residual)


def gains_in_doubt(findings, odd, joints):
    """Return sentences on Findings of gains, suspected as drives saturate at the indices odd."""
    odd = {joints[j] for j in odd}
    return tuple(f'{", ".join(sorted(odd & set(finding.joints)))}: {GAIN} is only suspected, '
                 'because a function of torque tells as much or more: the drive, or its reported '
                 'effort, may saturate' for finding in findings if finding.name == GAIN
                 and finding.verdict == SUSPECTED and odd & set(finding.joints))
