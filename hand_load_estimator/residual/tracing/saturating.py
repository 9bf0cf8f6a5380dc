"""
Whether a gain is one, or a drive that saturates.

A wrong torque constant leaves nothing that follows torque. An effort that ends softly, or a motor
whose torque falls behind its current, looks like a gain first; what is left is then taken for a
cable, friction or whatever follows torque by chance, though a plain function of torque tells more.
"""

import numpy as np

from ..diagnosis import SUSPECTED, UNKNOWN
from .plain_functions import TORQUES

GAIN = 'torque_scale'
# A function of torque whose bend moves more than this share of what the gain does speaks against
# it: a tanh has a quarter or more, and less only where the torque never changes its sign.
SATURATES = 0.2


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


def gains_in_doubt(findings, steps, joints):
    """Return sentences on Findings of gains, suspected for what Steps tell; joints: names (n,)."""
    odd = {joints[j] for j in saturating(steps, len(joints))}
    return tuple(f'{", ".join(sorted(odd & set(finding.joints)))}: {GAIN} is only suspected, '
                 'because a function of torque tells more: the drive, or its reported effort, '
                 'saturates' for finding in findings if finding.name == GAIN
                 and finding.verdict == SUSPECTED and odd & set(finding.joints))
