"""A gain of the effort that changes with temperature."""

from .effect import Effect


def _columns(x, j, _):
    return (x.drive[:, j] * x.warmth[:, j])[..., None]


TORQUE_SCALE_TEMPERATURE = Effect(
    'torque_scale_temperature', 'the gain of the effort changes with temperature: magnets lose '
    'strength as they warm, a joint torque sensor may drift',
    'Sebastian 1995', (('slope', '1/K'),), (3e-3,), _columns, in_link_torque=True,
    against='drive torque times warmth', needs=frozenset({'drive', 'warmth'}), absolute=True)
