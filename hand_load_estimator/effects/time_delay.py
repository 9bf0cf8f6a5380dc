"""Effort that comes late."""

import numpy as np

from .effect import Effect, Shape

LATE = 'time_delay'
# [s] Nothing of an arm's own comes later than its motion by so much; torque that seems to is no
# torque of that motion.
LATEST = 0.25


def _columns(x, j, shape):
    delays = np.ones(x.q.shape[1])
    delays[j] = shape['shift']
    return x.late(delays)[:, j][..., None]


def _derived(values, shape):
    return {'delay': (values[0] * shape['shift'], 's')}


TIME_DELAY = Effect(
    LATE, 'effort belongs to an earlier moment than the position beside it',
    'first principles: tau(t - d) of the model\'s own torque', (('share', '-'),), (1.0,), _columns,
    (Shape('shift', 's', 0.01, (0.003, 0.006, 0.01, 0.015, 0.022, 0.03, 0.045, 0.07),
           most=LATEST),),
    in_link_torque=True, against='rate of torque', derived=_derived,
    needs=frozenset({'late'}), absolute=True, positive=(0,))
