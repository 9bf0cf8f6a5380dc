"""The load that the tests of the whole estimator carry, and whether an estimate finds it."""

import numpy as np

MASS = 3.0


def within(estimate, load, width=3.5):
    """Tell whether mass and centre of mass are within so many standard deviations."""
    error = np.abs(estimate.mean - load.to_message())[:4]
    return bool((error < width * estimate.std[:4]).all())
