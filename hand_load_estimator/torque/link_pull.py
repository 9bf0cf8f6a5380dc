"""
What pulls on the links beside their weight: balancers, cables, and gravity of a leaning base.

Gears carry it as they carry links and load. A balancer is there to take the weight off the gear:
friction that grows with its torque, and the teeth that part as it changes sign, feel what is left.
"""

from dataclasses import replace

import numpy as np

from .shown_links import SPREAD


def link_pull(layout, x, mean, tilt=None):
    """
    Return (N, n) [Nm] twice: the torque, and how far it goes either way within the filter.

    layout: ColumnLayout; x: EffectInput; mean (P,): tells springs, cables and lean; tilt: as of
    EffectInput, None without a lean. How far the lean's share goes is left out: it is a hundredth
    of a weight's.
    """
    pull, way = np.zeros((2,) + x.q.shape)
    if layout.pulls:
        pull = layout.pull(x, mean)
        if x.jerk is not None:
            after, before = (layout.pull(replace(x, q=x.q + side * SPREAD * x.v), mean)
                             for side in (1.0, -1.0))
            way = 0.5 * (after - before)
    return pull if tilt is None else pull + tilt() @ layout.tilt(mean), way
