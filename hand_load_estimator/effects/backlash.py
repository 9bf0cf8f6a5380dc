"""Play in the gear."""

from .effect import Effect, Shape


def _columns(x, j, shape):
    return x.play(j, shape['travel'], shape['lag'], shape['pose_share'],
                  shape['impact'])[..., None]


BACKLASH = Effect(
    'backlash', 'play: when the torque of the gear changes sign the teeth part, and meet again '
    'with an impact; how long they take tells the product of travel and inertia that crosses',
    'Nordin and Gutman 2002', (('share', '-'),), (1.0,), _columns,
    # An impact lasts a few hundredths of a second: a coarser grid would meet none of them.
    (Shape('travel', 'rad', 1e-3, tuple(round(1e-4 * 1.36 ** k, 7) for k in range(20))),
     Shape('lag', 's', 0.01, (0.007, 0.016)), Shape('pose_share', '-', 1.0, (0.01, 1.0)),
     # Without a figure, as in model files from before it was there, the impact is over at once.
     Shape('impact', 's', 1e-4, (0.004, 0.012))),
    against='gear torque', needs=frozenset({'play'}), absolute=True, positive=(0,))
