"""
How the travel over which friction turns goes with temperature.

The contacts of a joint are springs (sigma_0 of Canudas de Wit et al. 1995), as stiff with warm
grease as with cold. What temperature changes is the level up to which they bend, Coulomb friction
and Stribeck peak: a joint whose friction is half of what it was turns around within half the
travel.
"""

from dataclasses import dataclass

import numpy as np

from ..effects.knee import KNEE
from .columns import effect_slices, first_of_joints

# Far outside the temperatures of a recording a straight line may foretell any level: travels are
# no shorter and no longer than so many times those at the reference temperature.
LEAST, MOST = 0.1, 10.0
# Coulomb friction of less than this share of the drive's torque is too little to tell by how much
# of itself temperature changes it.
TOLD = 0.005


@dataclass(frozen=True, eq=False)
class TravelGrowth:
    """
    Travels in times those at the reference temperature.

    slope (n,) [1/K]: of a joint's friction, in levels; knee (n,) [K]: warmth from which on
    it stays.
    """

    slope: np.ndarray
    knee: np.ndarray

    def __call__(self, warmth):
        """Return (..., n) [-] at warmths (..., n) [K]."""
        return np.clip(1.0 + self.slope * np.minimum(warmth, self.knee), LEAST, MOST)


def travel_growth(robot, uses, mean):
    """
    Return the TravelGrowth of a Robot's joints, None for none; mean (P,): of uses and links.

    None for joints whose level is hardly told, and for those with friction that grows with the
    load: what of their level temperature changes nobody knows beforehand.
    """
    n = robot.n
    slope, knee, level = np.zeros(n), np.full(n, np.inf), friction_level(n, uses, mean)
    told = first_of_joints(n, uses, 'coulomb_friction', mean) > TOLD * robot.limits.torque
    told[[use.joint for use in uses if use.name == 'load_dependent_friction']] = False
    for use, where in effect_slices(n, uses):
        if use.name == 'temperature_dependent_coulomb_friction' and told[use.joint]:
            slope[use.joint] = mean[where.start] / level[use.joint]
            knee[use.joint] = use.shape[KNEE.name]
    return TravelGrowth(slope, knee) if slope.any() else None


def friction_level(n, uses, mean):
    """
    Return the largest sliding friction (n,) [Nm] at low speed and the reference temperature.

    mean (P,): of uses and links.
    """
    coulomb, stribeck = (first_of_joints(n, uses, name, mean) for name in
                         ('coulomb_friction', 'stribeck_friction'))
    return np.maximum(np.abs(coulomb), np.abs(coulomb + stribeck))
