"""Random loads a hand may hold: boxes of some size, held off centre and askew."""

import numpy as np

from ..load import LoadParameters


def _random_rotation(rng):
    quaternion = rng.normal(size=4)
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def random_load(rng, robot, empty=0.06):
    """
    Return LoadParameters from nothing to the rated mass.

    rng: numpy Generator; empty: share of loads that are nothing at all. Sides are 0.04 to 0.35 m
    at 12.5 kg and grow with the cube root of the rated mass.
    """
    if rng.random() < empty:
        return LoadParameters()
    rated = robot.rated_load
    size = (rated.mass / 12.5) ** (1.0 / 3.0)
    mass = rated.mass * rng.uniform(0.005, 1.0)
    sides = rng.uniform(0.04, 0.35, 3) * size
    inertia = mass / 12.0 * np.diag(np.sum(sides ** 2) - sides ** 2)
    rotation = _random_rotation(rng)
    com = rated.com + rng.normal(0.0, [0.06, 0.06, 0.06]) * size
    return LoadParameters(mass, com, rotation @ inertia @ rotation.T)
