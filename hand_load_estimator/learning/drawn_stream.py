"""A training sequence as the stream of samples and predictions that a method sees."""

import numpy as np

from ..motion import MotionSample
from ..torque.model_follower import Prediction
from ..torque.presliding import stuck_variance
from .sequences import EVERY, RATE

DT = EVERY / RATE


def drawn_stream(robot, sequence):
    """Yield (MotionSample, Prediction) of each step of a Sequence; its columns are scaled."""
    q, v, a = np.moveaxis(sequence.motion.astype(float), 1, 0)
    difference, columns, density, z, doubt = (
        getattr(sequence, name).astype(float)
        for name in ('difference', 'columns', 'density', 'z', 'doubt'))
    temperature = sequence.warmth + robot.reference_temperature
    stuck = stuck_variance(z, doubt, v, sequence.level)
    scale = np.ones(columns.shape[2] - 10)
    for k in range(len(q)):
        sample = MotionSample((k + 1) * DT, DT, q[k], v[k], a[k], np.full(robot.n, np.nan),
                              temperature[k], fresh=False, messages=EVERY)
        yield sample, Prediction(difference[k], columns[k, :, :10], columns[k, :, 10:], z[k],
                                 doubt[k], stuck[k], sequence.level, density[k], scale)
