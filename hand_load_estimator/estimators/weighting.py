"""The rows a sample adds to the regression (eq. 12), and what it says that was not expected."""

import numpy as np


def joined_columns(prediction):
    """Return (n, 10 + r): load columns beside the model's, as estimates count them."""
    uncertain = prediction.model_columns * prediction.column_scale
    return np.concatenate([prediction.load_columns, uncertain], axis=1)


def innovation_of(prediction, columns, known, posterior):
    """
    Return innovation, its variance by the belief about the load [Nm^2], the load's torque, (n,).

    known (10 + r,): products and nuisances believed; posterior: the Posterior they belong to.
    """
    load = prediction.load_columns
    spread = (load.dot(posterior.products_covariance) * load).sum(axis=1)
    return (prediction.difference - columns.dot(known), np.maximum(spread, 0.0),
            load.dot(known[:10]))
