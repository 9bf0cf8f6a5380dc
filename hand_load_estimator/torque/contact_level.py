"""
The level up to which the contacts of a joint bend, as temperature and speed change it.

All of a joint's friction is borne by contacts that are springs (sigma_0 of Canudas de Wit et al.
1995), as stiff with warm grease as with cold, and they bend up to what the joint would slide at:
Coulomb friction and what is left of the Stribeck peak (Dupont et al. 2002). A joint whose friction
is half of what it was turns around within half the travel; where a peak comes back as it slows
down, the contacts have to bend again, and where it goes they let go.
"""

from dataclasses import dataclass

import numpy as np

from ..effects.knee import KNEE
from ..effects.own_travel import OWN_TRAVEL
from ..effects.stribeck_curve import left
from .columns import effect_slices, first_of_joints

# Far outside the temperatures of a recording a straight line may foretell any level: travels are
# no shorter and no longer than so many times those at the reference temperature.
LEAST, MOST = 0.1, 10.0
# Coulomb friction of less than this share of the drive's torque is too little to tell by how much
# of itself temperature and speed change it.
TOLD = 0.005
# A peak is at most such a share of the level: of all of it nothing were left at speed.
MOST_PEAK = 0.95
# A peak of joints that have none.
NO_PEAK = (0.1, 1.0, np.inf)


@dataclass(frozen=True, eq=False)
class ContactLevel:
    """
    The levels of n joints in times those at the reference temperature, most slowly.

    slope (n,) [1/K]: of a joint's friction, in levels; knee (n,) [K]: warmth from which on
    it stays; share (n,) [-] of the peak; peak (3, n): stribeck_curve.left's velocity, exponent
    and range of it.
    """

    slope: np.ndarray
    knee: np.ndarray
    share: np.ndarray
    peak: np.ndarray

    def warmed(self, warmth):
        """Return what temperature makes of the levels (..., n) [-] at warmths (..., n) [K]."""
        return np.clip(1.0 + self.slope * np.minimum(warmth, self.knee), LEAST, MOST)

    def fallen(self, speeds, warmth):
        """Return what is left of them (..., n) [-] at speeds (..., n) [rad/s], None for all."""
        if not self.share.any():
            return None
        return 1.0 - self.share + self.share * left(speeds, warmth, *self.peak)


def contact_level(robot, uses, mean):
    """
    Return the ContactLevel of a Robot's joints, None for none; mean (P,): of uses and links.

    None for joints whose level is hardly told, and for those with friction that grows with the
    load: what of their level temperature and speed change nobody knows beforehand.
    """
    n = robot.n
    slope, knee, level = np.zeros(n), np.full(n, np.inf), friction_level(n, uses, mean)
    share, peak = np.zeros(n), np.tile(NO_PEAK, (n, 1)).T
    told = first_of_joints(n, uses, 'coulomb_friction', mean) > TOLD * robot.limits.torque
    told[[use.joint for use in uses if use.name == 'load_dependent_friction']] = False
    for use, where in effect_slices(n, uses):
        if not told[use.joint]:
            continue
        if use.name == 'temperature_dependent_coulomb_friction':
            slope[use.joint] = mean[where.start] / level[use.joint]
            knee[use.joint] = use.shape[KNEE.name]
        # A peak that turns over a travel of its own has contacts of its own.
        elif use.name == 'stribeck_friction' and np.isinf(use.shape[OWN_TRAVEL.name]):
            share[use.joint] = np.clip(mean[where.start] / level[use.joint], 0.0, MOST_PEAK)
            peak[:, use.joint] = [use.shape[name] for name in
                                  ('stribeck_velocity', 'exponent', 'velocity_range')]
    return ContactLevel(slope, knee, share, peak) if slope.any() or share.any() else None


def friction_level(n, uses, mean):
    """
    Return the largest sliding friction (n,) [Nm] at low speed and the reference temperature.

    mean (P,): of uses and links.
    """
    coulomb, stribeck = (first_of_joints(n, uses, name, mean) for name in
                         ('coulomb_friction', 'stribeck_friction'))
    return np.maximum(np.abs(coulomb), np.abs(coulomb + stribeck))
