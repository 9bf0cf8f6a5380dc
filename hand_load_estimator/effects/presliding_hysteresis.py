"""Friction before a joint has really moved."""

import numpy as np

from .effect import Effect, Shape
from .own_travel import BOTH, PLASTIC

PRESLIDING = 'presliding_hysteresis'
# [rad] Friction that turns over a longer way is hardly told from another level of it.
LONGEST = 1.0


def _columns(x, j, _):
    # All friction turns as z does; what this has a level for turns more, or less, than it.
    return (x.z[:, j] - x.sign[:, j])[..., None]


PRESLIDING_HYSTERESIS = Effect(
    PRESLIDING, 'friction turns over a short travel after a reversal',
    'Dahl 1968; Dupont et al. 2002',
    (('level', 'Nm'),), (0.003,), _columns,
    (Shape('presliding_distance', 'rad', 1e-3,
           (2e-4, 3.5e-4, 6e-4, 1e-3, 1.7e-3, 2.9e-3, 5e-3), most=LONGEST),
     # Yielding all the way, as Dahl's contacts do, or its last quarter.
     Shape(PLASTIC.name, PLASTIC.unit, BOTH, (BOTH, 0.5), PLASTIC.gain, PLASTIC.least,
           PLASTIC.most)),
    against='travel since reversal', default=True)
