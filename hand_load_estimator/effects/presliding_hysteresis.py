"""Friction before a joint has really moved."""

from .effect import Effect, Shape
from .own_travel import POWER

# [rad] Friction that turns over a longer way is hardly told from another level of it.
LONGEST = 1.0


def _columns(x, j, _):
    return (x.z[:, j] - x.sign[:, j])[..., None]


PRESLIDING_HYSTERESIS = Effect(
    'presliding_hysteresis', 'friction turns over a short travel after a reversal',
    'Dahl 1968; Al-Bender et al. 2005',
    (('level', 'Nm'),), (0.1,), _columns,
    (Shape('presliding_distance', 'rad', 1e-3, (2e-4, 4e-4, 7e-4, 1e-3, 1.5e-3, 2.5e-3, 5e-3),
           most=LONGEST),
     # Of the way it turns (presliding.Turning); only a residual tells it.
     POWER),
    against='travel since reversal', default=True, positive=(0,))
