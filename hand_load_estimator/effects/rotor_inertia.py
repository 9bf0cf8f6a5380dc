"""The rotor behind the gear."""

from .effect import Effect


def _columns(x, j, _):
    return x.a[:, j][..., None]


ROTOR_INERTIA = Effect(
    'rotor_inertia', 'torque in proportion to joint acceleration: the rotor behind the gear',
    'Swevers et al. 2007', (('inertia', 'kg m^2'),), (0.02,), _columns, against='acceleration',
    default=True, positive=(0,))
