"""The rows a sample adds to the regression (eq. 12)."""

import numpy as np


def joined_columns(prediction):
    """Return (n, 10 + r): load columns beside the model's uncertain directions."""
    return np.hstack([prediction.load_columns, prediction.model_columns])
