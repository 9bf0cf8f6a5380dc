"""Random loads a hand may hold: boxes and ellipsoids of some size, held off centre and askew."""

import numpy as np

from ..load import LoadParameters

# Half the length [m] along each axis, for a rated load of 12.5 kg, and moment of inertia over mass
# and squares of half lengths.
SHAPES = {'box': ((0.02, 0.175), 1.0 / 3.0), 'ellipsoid': ((0.03, 0.2), 1.0 / 5.0)}


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

    rng: numpy Generator; empty: share of loads that are nothing at all. Lengths grow with the cube
    root of the rated mass.
    """
    if rng.random() < empty:
        return LoadParameters()
    rated = robot.rated_load
    size = (rated.mass / 12.5) ** (1.0 / 3.0)
    mass = rated.mass * rng.uniform(0.005, 1.0)
    half_lengths, share = SHAPES[rng.choice(list(SHAPES))]
    half = rng.uniform(*half_lengths, 3) * size
    inertia = share * mass * np.diag(np.sum(half ** 2) - half ** 2)
    rotation = _random_rotation(rng)
    com = rated.com + rng.normal(0.0, [0.06, 0.06, 0.06]) * size
    return LoadParameters(mass, com, rotation @ inertia @ rotation.T)
