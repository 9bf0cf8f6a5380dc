"""Friction of constant size."""

from .effect import Effect


def _columns(x, j, _):
    return x.z[:, j][..., None]


COULOMB_FRICTION = Effect(
    'coulomb_friction', 'constant against the motion', 'Coulomb 1785', (('level', 'Nm'),), (0.1,),
    _columns, default=True, positive=(0,))
