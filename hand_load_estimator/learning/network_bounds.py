"""
Bounds of the network's outputs, as training and the running estimator both use them.

CORRECTION in friction levels; SHIFT in standard deviations; SPREAD in e-folds.
"""

CORRECTION, SHIFT, SPREAD = 0.5, 1.5, 1.5
