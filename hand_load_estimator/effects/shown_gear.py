"""
The size of a gear's torque as the motion filter shows it.

Friction in the teeth grows with |g|, and what the filter shows of it is F[|g|], which is more than
|F[g]| while the torque g of the gear turns round: where an arm snaps to a stop, by the torque of
half the snap. Within the filter g is about its mean and a normal spread, so that its size is that
of a folded normal (Leone, Nelson and Nottingham 1961).
"""

import numpy as np
from scipy.special import erf

# Less than this [Nm] is no spread: the torque of a gear passes through zero in no time at all.
_LEAST = 1e-9


def shown_size(torque, way):
    """Return the mean size [Nm] of torques that go `way` [Nm] to either side of a mean [Nm]."""
    spread = np.maximum(np.abs(way), _LEAST)
    bent = np.sqrt(2.0 / np.pi) * spread * np.exp(-0.5 * (torque / spread) ** 2)
    return bent + torque * shown_side(torque, way)


def shown_side(torque, way):
    """Return their mean sign in [-1, 1], by which the size changes with the torque."""
    return erf(torque / (np.sqrt(2.0) * np.maximum(np.abs(way), _LEAST)))
