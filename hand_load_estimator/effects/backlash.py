"""Play in the gear."""

from .effect import Effect, Shape


def _columns(x, j, shape):
    return x.play(j, shape['travel']) * (1.0, -1.0)


BACKLASH = Effect(
    'backlash', 'play: when the torque of the gear changes sign the teeth part, and meet again with '
    'an impact', 'Nordin and Gutman 2002', (('share', '-'), ('lag', 's')), (1.0, 0.02), _columns,
    (Shape('travel', 'rad', 1e-3, (2e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 0.016, 0.03, 0.05)),),
    against='gear torque', needs=frozenset({'play'}), absolute=True, positive=(0,))
