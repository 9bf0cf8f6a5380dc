"""A wrong gain of the reported effort."""

from .effect import Effect


def _columns(x, j, _):
    return x.drive[:, j][..., None]


TORQUE_SCALE = Effect(
    'torque_scale', 'gain of the reported effort: a torque constant, or the gain of a joint '
    'torque sensor, that is off',
    'Gautier and Briot 2014', (('gain', '-'),), (0.1,), _columns, in_link_torque=True,
    against='drive torque', needs=frozenset({'drive'}), absolute=True)
