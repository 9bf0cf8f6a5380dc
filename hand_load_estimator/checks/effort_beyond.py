"""Is the effort larger than any drive of the arm makes: another unit."""

import numpy as np

from ..stream.input_guard import EFFORT_MARGIN
from .finding import Finding, WRONG

# Share of the time: a few broken messages are no unit.
_OFTEN = 0.05
_WITHIN = (0.33, 3.0)
# Times the torque of gravity -> what it looks like; an ampere makes about 10 Nm at the joint.
_OF_TORQUE = {1000.0: ('mNm', 'Nm'), 100.0: ('mA', 'A, and say kind motor_current')}
_OF_CURRENT = {1000.0: ('mA', 'A')}


def check_beyond(signals, terms, robot):
    """Return the finding about an effort that the estimator rejects for its size, or None."""
    share = np.abs(signals.effort) / robot.limits.torque
    often = np.mean(share > EFFORT_MARGIN, axis=0)
    j = int(np.argmax(often))
    if often[j] < _OFTEN:
        return None
    text = (f'{100.0 * often[j]:.0f} % of the time beyond {100.0 * EFFORT_MARGIN:.0f} % of '
            f'max_torque on {robot.joints[j]}; such messages are rejected')
    return Finding('effort unit', WRONG, text, _todo(_size(signals, terms, robot), robot))


def _size(signals, terms, robot):
    """Return how many times the torque of gravity the effort is, or 0 where none acts."""
    expected = terms.gravity @ np.array(robot.file.gravity)
    return abs(np.sum(signals.effort * expected)) / max(np.sum(expected**2), 1e-12)


def _todo(size, robot):
    units = _OF_CURRENT if robot.effort.kind == 'motor_current' else _OF_TORQUE
    for factor, (unit, wanted) in units.items():
        if _WITHIN[0] <= size / factor <= _WITHIN[1]:
            return (f'looks like {unit}, about {size:.0f} times the torque of gravity: have the '
                    f'driver publish {wanted}')
    return 'compare max_torque, effort.kind and torque_constants with the driver'
