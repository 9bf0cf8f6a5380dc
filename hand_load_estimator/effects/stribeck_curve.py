"""
The Stribeck curve: what is left of breakaway friction as lubrication builds up with speed.

Bittencourt and Axelsson (2014) measured exp(-(|v| / v_s)^alpha) at joints of industrial robots,
with alpha about 1.3 and a Stribeck velocity v_s that rises as the grease warms, in a straight
line. Here it rises as an exponential of the warmth, which stays positive when it is cold; beyond
the temperatures that it was found at either is a guess.
"""

import numpy as np


def left(v, warmth, velocity, exponent=1.0, velocity_range=np.inf):
    """
    Return the share [-] of the peak that is left at speeds v [rad/s], of any shape.

    warmth [K]: temperature above the reference; velocity [rad/s]: where 1 / e is left at the
    reference; velocity_range [K]: by which the joint warms until that velocity is e times larger.
    """
    return np.exp(-(np.abs(v) / (velocity * np.exp(warmth / velocity_range))) ** exponent)
