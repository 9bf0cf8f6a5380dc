"""
Whether what was found may be an effort that ends softly.

Where the bend of such an effort is small, or friction is most of the torque, no function of torque
is found beside the gain that comes nearest (saturating.py), and friction makes up for the rest. So
every gain is compared with soft ends in its place, and what else was found at its joint is asked
again beside these.
"""

import numpy as np

from ..diagnosis import UNKNOWN
from .candidate import ahead, evaluated, significant, single
from .hypothesis import beside_delays, Hypothesis
from .saturating import GAIN

# Where an effort may end softly, in times the largest torque that the joint has shown. What ends
# farther off bends as the last of these does. A motor whose torque falls behind its current does
# the opposite, and never has a torque beyond its end.
ENDS = (0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 2.0)


def own_gains(steps):
    """Return the Steps of gains that joints have by themselves: no drives saturate alike."""
    return [step for step in steps if step.chosen.name == GAIN and not step.chosen.common]


def soft_ends(found, known):
    """
    Return {joint index: Candidates} of the soft ends that a gain Found is not surely more than.

    A Candidate is e tanh(torque / e) - torque in any amount; torque: the drive's. known: indices
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
    there, found = single(gain, blocks.evaluate(gain.columns)), []
    for end in ENDS:
        softly = _softly(gain.joint, end, residual)
        score = blocks.evaluate(softly.columns)
        possible = score.theta[0] > 0.0 or end >= 1.0
        if possible and not significant(ahead(there, single(softly, score))):
            found.append(single(softly, score))
    return found


def _softly(j, end, residual):
    """Return the Hypothesis `unknown` of joint j whose effort ends at one of ENDS."""
    torque = residual.x.drive[:, j]
    end = end * np.abs(torque[residual.weights[:, j] > 0.0]).max()
    columns = (end * np.tanh(torque / end) - torque)[:, None]
    return beside_delays(Hypothesis(UNKNOWN, j, {j: columns}, np.ones(1),
                                    variable='drive torque'), residual)


def may_end_softly(step, ends, found):
    """
    Tell whether a Step of Found is a gain of soft_ends, or gains nothing sure beside one of them.

    What gains beside the gain only makes up for what that leaves of a soft end.
    """
    joints = step.chosen.joints
    if step.chosen.name == UNKNOWN or not ends.keys() >= set(joints):
        return False
    gains = [gain for gain in own_gains(found.steps) if set(gain.chosen.joints) & set(joints)]
    return any(step is gain for gain in gains) or bool(gains) and any(
        again.gain < step.needed or not significant(again)
        for j in joints for end in ends[j]
        for again in [evaluated(step.chosen, found.beside(step, *gains).beside(end.columns))])


def soft_end_doubts(steps, joints):
    """Return a sentence for each of Steps that may_end_softly; joints: names (n,)."""
    return tuple(
        f'{", ".join(joints[j] for j in step.chosen.joints)}: {step.chosen.name} is only '
        'suspected, because ' + ('an effort that ends softly is not surely told from it'
                                 if step.chosen.name == GAIN else
                                 'beside an effort that ends softly it gains nothing sure')
        for step in steps)
