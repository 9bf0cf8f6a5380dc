"""
Bounds of the network's outputs, as training and the running estimator both use them.

CORRECTION in friction levels; GAIN and SPREAD in e-folds; SHIFT in standard deviations.
"""

CORRECTION, GAIN, SHIFT, SPREAD = 0.5, 6.0, 1.5, 1.5
