"""Play in the gear."""

import numpy as np

from .effect import Effect, Shape


def _columns(x, j, shape):
    gear = x.gear[:, j]
    near = np.exp(-(gear / shape['width']) ** 2)
    return np.stack([-near * gear, near * x.rate[:, j]], axis=-1)


BACKLASH = Effect(
    'backlash', 'play: while the torque of the gear changes sign the teeth carry nothing',
    'Nordin and Gutman 2002', (('loss', '-'), ('lag', 's')), (1.0, 0.05), _columns,
    (Shape('width', 'Nm', 2.0, (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)),), against='gear torque',
    needs=frozenset({'gear', 'rate'}), absolute=True, positive=(0,))
