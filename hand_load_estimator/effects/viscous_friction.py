"""Friction in proportion to velocity."""

from .effect import Effect


def _columns(x, j, _):
    return x.v[:, j][..., None]


VISCOUS_FRICTION = Effect(
    'viscous_friction', 'in proportion to velocity', 'Armstrong-Helouvry et al. 1994',
    (('coefficient', 'Nm s/rad'),), (0.1,), _columns, default=True,
    positive=(0,))
