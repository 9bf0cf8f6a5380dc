"""What a hand may hold before data tell: a wide prior in shape parameters (load.py)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..load import products_from_shape, products_jacobian_of_shape

# Radii of gyration squared [m^2] of what a rated load of 10 kg looks like: 0.05 to 0.4 m across.
GYRATION_MEAN, GYRATION_STD, GYRATION_CROSS_STD = 0.007, 0.006, 0.002
COM_STD = 0.08
# Of an empty hand nothing is left in what comes. Nor may the centre weigh next to nothing: moments
# are products with the mass, and what they may be would be linearised away.
LIGHT = 0.5


@dataclass(frozen=True)
class LoadPrior:
    """Mean (10,) and standard deviations (10,) in shape order."""

    mean: np.ndarray
    std: np.ndarray

    @cached_property
    def half_scale(self):
        """Half the products (10, 10) of standard deviations: a covariance's scale, in halves."""
        return 0.5 * np.outer(self.std, self.std)

    @cached_property
    def products(self):
        """Mean (10,) and covariance (10, 10) of the products, by linearisation."""
        jacobian = products_jacobian_of_shape(self.mean)
        return products_from_shape(self.mean), jacobian @ np.diag(self.std ** 2) @ jacobian.T

    def after(self, shape):
        """
        Return the LoadPrior once another load seems to be held than one of a shape (10,).

        What seems to be another load may be the same, or the same elsewhere in the hand: it is
        centred there, less so the less that weighs beside LIGHT times this prior's mass. Its
        variance is the mean square by which a load of this prior differs from the centre.
        """
        share = np.clip(shape[0] / (LIGHT * self.mean[0]), 0.0, 1.0)
        away = share * (shape - self.mean)
        return LoadPrior(self.mean + away, np.hypot(self.std, away))


def load_prior(robot):
    """Return the LoadPrior of a robot: from nothing to its rated load, around its rated place."""
    rated = robot.rated_load
    # Loads are as wide as an arm's payload allows: lengths grow with the cube root of mass.
    size = (rated.mass / 12.5) ** (1.0 / 3.0)
    g = np.array([GYRATION_MEAN, 0.0, 0.0, GYRATION_MEAN, 0.0, GYRATION_MEAN]) * size ** 2
    g_std = np.array([GYRATION_STD, GYRATION_CROSS_STD, GYRATION_CROSS_STD,
                      GYRATION_STD, GYRATION_CROSS_STD, GYRATION_STD]) * size ** 2
    mean = np.concatenate([[0.4 * rated.mass], rated.com, g])
    std = np.concatenate([[0.4 * rated.mass], np.full(3, COM_STD * size), g_std])
    return LoadPrior(mean, std)
