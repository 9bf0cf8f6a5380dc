"""Friction before a joint has really moved."""

import numpy as np

from .effect import Effect, Shape
from .own_travel import POWER

PRESLIDING = 'presliding_hysteresis'
# [rad] Friction that turns over a longer way is hardly told from another level of it.
LONGEST = 1.0


def _columns(x, j, _):
    # All friction turns as z does; what this has a level for turns more, or less, than it.
    return (x.z[:, j] - x.sign[:, j])[..., None]


PRESLIDING_HYSTERESIS = Effect(
    PRESLIDING, 'friction turns over a short travel after a reversal',
    'Dahl 1968; Al-Bender et al. 2005',
    (('level', 'Nm'),), (0.003,), _columns,
    (Shape('presliding_distance', 'rad', 1e-3,
           (2e-4, 3.5e-4, 6e-4, 1e-3, 1.7e-3, 2.9e-3, 5e-3), most=LONGEST),
     # Of the way it turns (presliding.Turning): Dahl's exponent 1, or a third.
     Shape(POWER.name, POWER.unit, np.inf, (np.inf, 1.5), POWER.gain, POWER.least)),
    against='travel since reversal', default=True)
