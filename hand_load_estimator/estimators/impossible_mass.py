"""A mass that no load has: torque model, tool or tare do not fit the arm."""

import math

from .physical_consistency import CONTRADICTION


def impossible_mass(belief, tared_mass):
    """
    Return the sentence on a mass surely below zero, empty where a load may have it.

    belief: a Method's; tared_mass [kg]: what tare declared zero, and may be gone.
    """
    mass, std = float(belief.mean[0]) + tared_mass, math.sqrt(belief.covariance[0, 0])
    if mass >= -CONTRADICTION * std:
        return ''
    return (f'the mass is {mass:.3g} kg, and no load weighs less than nothing: the torque model '
            'or the tool does not fit the arm (was the model identified with a load on the hand '
            'that was not declared?); run hand_load check')
