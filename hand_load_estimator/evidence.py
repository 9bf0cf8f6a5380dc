"""Recordings made ready for identification: motion, and torque less a known load's."""

from dataclasses import dataclass, field

import numpy as np

from .errors import RecordingError
from .load import LoadParameters
from .torque_columns import real_torque


@dataclass(frozen=True)
class Evidence:
    """
    One recording made ready, or a part of it: name of the recording, Motion, torque less the known
    load's (N, n) [Nm].

    held (N, n) [Nm]: the known load's torque, which drives and gears carry all the same, or None;
    load: LoadParameters declared.
    """

    name: str
    motion: object
    torque: np.ndarray
    held: np.ndarray | None = None
    load: LoadParameters = field(default_factory=LoadParameters)


def recording_numbers(evidence):
    """Return for each Evidence the number of its recording: parts of one have its name."""
    names = list(dict.fromkeys(e.name for e in evidence))
    return [names.index(e.name) for e in evidence]


def prepare(robot, name, motion, load):
    """Return the Evidence of a Motion recorded with the given LoadParameters."""
    if len(motion.stamp) == 0:
        raise RecordingError(f'{name}: holds no usable joint states')
    torque = np.array([real_torque(robot, q, e) for q, e in zip(motion.q, motion.effort)])
    if load.mass == 0.0:
        return Evidence(name, motion, torque)
    products = load.to_products()
    held = np.array([robot.load_regressor(q, v, a) @ products
                     for q, v, a in zip(motion.q, motion.v, motion.a)])
    return Evidence(name, motion, torque - held, held, load)
