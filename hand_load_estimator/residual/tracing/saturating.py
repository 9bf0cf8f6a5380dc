"""
Whether a gain is one, or a drive that saturates.

A wrong torque constant leaves nothing that follows torque. An effort that ends softly, or a motor
whose torque falls behind its current, looks like a gain first; what is left is then taken for a
cable, friction or whatever follows torque by chance, though a plain function of torque tells more.
"""

import numpy as np

from ..diagnosis import UNKNOWN
from .plain_functions import TORQUES

GAIN = 'torque_scale'
# A function of torque that moves more than this share of what the gain does speaks against it; a
# tanh leaves a third or more.
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
    moved, by_gain = (np.linalg.norm(c.torque(n)[:, candidate.joints]) for c in (candidate, gain))
    return bool(moved > SATURATES * by_gain)
