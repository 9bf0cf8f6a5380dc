"""The rows a sample adds to the regression (eq. 12), and what it says that was not expected."""

import numpy as np


def joined_columns(prediction):
    """Return (n, 10 + r): load columns beside the model's uncertain directions."""
    return np.hstack([prediction.load_columns, prediction.model_columns])


def innovation_of(prediction, columns, known, posterior):
    """
    Return innovation (n,) [Nm] and the variance (n,) [Nm^2] that belief and friction give it.

    known (10 + r,): products and nuisances believed; posterior: the Posterior they belong to.
    """
    load = prediction.load_columns
    spread = np.einsum('ij,jk,ik->i', load, posterior.products_covariance, load)
    return prediction.difference - columns @ known, np.maximum(spread, 0.0) + prediction.stuck
