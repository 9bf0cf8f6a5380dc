"""The sign of a measured velocity."""

import numpy as np

# It is taken over this width [rad/s], a few times the velocity's noise.
SIGN_WIDTH = 0.01


def sign_of(v):
    """Return the smoothed sign of velocities [rad/s]."""
    return np.tanh(v / SIGN_WIDTH)
