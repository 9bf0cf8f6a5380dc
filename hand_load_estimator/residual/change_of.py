"""How sure the change of a figure is: the better model's doubt about it, and the old model's."""

import numpy as np


def change_covariance(model, better, before, after):
    """
    Return the covariance (k, k) of x[after] of the better model less x[before] of the old one.

    model, better: TorqueModels; before, after: places (k,) in their x. Their data are different
    ones, so both doubts count. NaN where the better model was made from no recording that the old
    one was not made from: then both err alike, and nobody has counted how much.
    """
    new, old = ({mark.content or mark.name for mark in m.recordings} for m in (better, model))
    if not new - old:
        return np.full((len(after), len(after)), np.nan)
    return better.covariance[np.ix_(after, after)] + model.covariance[np.ix_(before, before)]
