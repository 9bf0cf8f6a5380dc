"""Play in the gear."""

from .effect import Effect, Shape


def _columns(x, j, shape):
    return x.play(j, shape['travel'], shape['lag'], shape['pose_share'])[..., None]


BACKLASH = Effect(
    'backlash', 'play: when the torque of the gear changes sign the teeth part, and meet again '
    'with an impact', 'Nordin and Gutman 2002', (('share', '-'),), (1.0,), _columns,
    (Shape('travel', 'rad', 1e-3, (1e-4, 1.8e-4, 3.2e-4, 5.8e-4, 1.05e-3, 1.9e-3, 3.4e-3, 6.1e-3,
                                   0.011, 0.02, 0.036)),
     Shape('lag', 's', 0.01, (0.004, 0.02)), Shape('pose_share', '-', 1.0, (0.1, 1.0))),
    against='gear torque', needs=frozenset({'play'}), absolute=True, positive=(0,))
