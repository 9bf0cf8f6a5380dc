"""How much one sample of one joint says: precision times time, less when its friction sticks."""

import numpy as np

from ..presliding import STUCK_TIME


def sample_weights(prediction, intensity, dt):
    """
    Return (n,) precisions beta of a sample that stands for dt seconds.

    intensity (n,) [Nm^2 s]: low-frequency density of the model's residual. Where the path since
    rest is too short to know the friction, its level counts as an error lasting STUCK_TIME.
    """
    stuck = (prediction.doubt * prediction.friction) ** 2 * STUCK_TIME
    return dt / (intensity + stuck)


def joined_columns(prediction):
    """Return (n, 10 + r): load columns beside the model's uncertain directions."""
    return np.hstack([prediction.load_columns, prediction.model_columns])
