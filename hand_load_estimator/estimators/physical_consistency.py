"""
The physically possible load that is nearest to a belief.

Noise may put the mean where no body is: a mass below zero, or a negative second moment about the
centre of mass, where the pseudo-inertia is not positive definite. A mass below zero becomes
LIGHTEST, and what is negative of its inertia as small. Possible inertias of a mass above zero are
a convex set, cut out by half spaces: along every axis, second moment >= LEAST mass. A violated
one is met by the smallest change of the inertia in the metric of its covariance, which brings it
nearer to *every* possible inertia, the true one too. What is determined hardly moves; mass and
centre of mass, which say nothing of a body's shape, do not move at all.

Only what is published is changed. The recursion goes on from the mean of the data, which a
constraint would bias, and the covariance stays: it is the doubt before the constraint, never
smaller than the one after it, so intervals still hold.
"""

import math

import numpy as np
from scipy.linalg.lapack import dsyev

from ..load import inertia_of_second_moments, second_moment_row, second_moments
from .method import Belief

# The least mass [kg], and the least radius of gyration squared [m^2] along any axis: nobody holds
# less than a milligram, and nothing that is held is thinner than a millimetre.
LIGHTEST, LEAST = 1e-6, 1e-6
# Steps aim at twice the least and further by a share of what lacks: where half spaces meet they
# would creep. A step of less than twice the distance still comes nearer to all of the set.
AIM, FURTHER, STEPS = 2.0, 0.2, 20
# Moments so much smaller than the largest are as good as zero: their product is lost in rounding.
ROUNDING = 1e-7
# A mass or moment below zero by more standard deviations is no noise.
CONTRADICTION = 3.0


def published(belief, method):
    """
    Return a Method's Belief as users see it: physically consistent unless something was tared.

    What is lighter than what was tared has a negative mass, and rightly.
    """
    return belief if method.tared.any() else physically_consistent(belief)


def physically_consistent(belief):
    """
    Return the Belief with the nearest possible mean, or as it is where it was possible.

    Where that takes a step of more than CONTRADICTION standard deviations, data and physics
    contradict each other (a tool was taken off, the model is wrong): the belief comes back as it
    is, because users and controller should see it.
    """
    mean, covariance = belief.mean, belief.covariance
    if _is_body(mean[0], mean[4:]):
        return belief
    if mean[0] < -CONTRADICTION * np.sqrt(covariance[0, 0]):
        return belief
    mass, inertia = max(mean[0], LIGHTEST), mean[4:]
    inertia = (_nearest(mass, inertia, covariance[4:, 4:]) if mass > LIGHTEST
               else _raised(mass, inertia))
    if inertia is None:
        return belief
    return Belief(np.concatenate([[mass], mean[1:4], inertia]), covariance)


def _nearest(mass, inertia, covariance):
    """Return the possible inertia (6,) near to one of covariance (6, 6); None: contradiction."""
    for _ in range(STEPS):
        if _is_body(mass, inertia):
            return inertia
        moments, axes, _ = dsyev(second_moments(inertia))
        row = second_moment_row(axes[:, 0])
        gain = covariance.dot(row)
        lack, variance = AIM * LEAST * mass - moments[0], row.dot(gain)
        if moments[0] < -CONTRADICTION * math.sqrt(max(variance, 0.0)):
            return None
        if variance <= 0.0:
            break
        inertia = inertia + gain * ((1.0 + FURTHER) * lack / variance)
    return _raised(mass, inertia)


def _raised(mass, inertia):
    """Return inertia (6,), moments below the least raised to it, whatever the covariance says."""
    moments, axes, _ = dsyev(second_moments(inertia))
    least = max(AIM * LEAST * mass, ROUNDING * moments[-1])
    return inertia_of_second_moments(axes * np.maximum(moments, least) @ axes.T)


def _is_body(mass, inertia):
    """Tell by leading minors, without eigenvalues, whether a load can be; inertia (6,)."""
    xx, xy, xz, yy, yz, zz = inertia.tolist()
    half = 0.5 * (xx + yy + zz) - LEAST * mass
    xx, yy, zz = half - xx, half - yy, half - zz
    minor = xx * yy - xy * xy
    return mass >= LIGHTEST and xx > 0.0 and minor > 0.0 and (
        minor * zz - 2.0 * xy * xz * yz - xx * yz * yz - yy * xz * xz > 0.0)
