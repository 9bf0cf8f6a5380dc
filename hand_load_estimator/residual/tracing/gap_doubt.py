"""
How well the travel of a gap is known: it goes with the inertia that crosses.

How long a crossing takes tells the product of both, and an impact returns what the crossing
spared, whatever the inertia. Where the pose does not show, that of the links at any of the poses
seen may have crossed.
"""

from dataclasses import replace

import numpy as np

GAP, TRAVEL = 'backlash', 'travel'


def with_unknown_inertia(doubt, hypothesis, residual):
    """
    Return the ShapeDoubt of a Hypothesis with what its inertia leaves open of its travel.

    residual: of whose x.play the links' inertias are. Of other effects than a gap: as it is.
    """
    if hypothesis.name != GAP or TRAVEL not in doubt.std:
        return doubt
    open_share = (1.0 - hypothesis.shape['pose_share']) * residual.x.play.off_usual(
        hypothesis.joint)
    std = np.hypot(doubt.std[TRAVEL], open_share * hypothesis.shape[TRAVEL])
    return replace(doubt, std={**doubt.std, TRAVEL: float(std)})
