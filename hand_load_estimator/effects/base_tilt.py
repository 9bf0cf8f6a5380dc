"""A base that leans."""

from .effect import Effect


def _columns(x, j, _):
    return x.tilt[:, j]


BASE_TILT = Effect(
    'base_tilt', 'gravity does not point where the robot file says: one small rotation',
    'gravity of the nominal links', (('about_x', 'rad'), ('about_y', 'rad')), (1e-4, 1e-4),
    _columns, in_link_torque=True, against='position', whole_arm=True, needs=frozenset({'tilt'}))
