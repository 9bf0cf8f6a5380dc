"""What /diagnostics says of the input: what arrives, what is refused, what is not known."""

from collections import Counter

import numpy as np

from ..effects import NEEDS_TEMPERATURE
from ..stream.joint_temperatures import joint_index
from .diagnostics import ERROR, OK, STALE, WARN

_KINDS = ('joint_states', 'temperatures')
_MISSING = (ERROR, 'no joint states have arrived')
_UNUSABLE = ('no usable joint state in the last second: those that arrive do not name all joints '
             'of this robot')
# Names of others that are told one by one; a driver that invents names must not fill the memory.
_MOST_NAMES = 10


class InputReport:
    """
    Counts messages and tells of them once a second.

    A model with temperature effects came from an arm whose temperatures were measured, so that
    their absence is a fault; the model of an arm without sensors has no such effect, and nothing
    is asked of it.
    """

    def __init__(self):
        self._taken, self._taken_before, self._rejected_before = Counter(), Counter(), 0
        self._others, self._newest_before = Counter(), None

    def joint_state(self):
        """Count a joint state."""
        self._taken['joint_states'] += 1

    def temperature(self, name, joints):
        """Count a temperature of that name; a gripper's is passed over, but told."""
        self._taken['temperatures'] += 1
        if joint_index(name, joints) is None and (name in self._others
                                                  or len(self._others) < _MOST_NAMES):
            self._others[name] += 1

    def report(self, pipeline):
        """Return (level, message, values) of the second that ends now."""
        rejected, known = pipeline.rejected, np.isfinite(pipeline.temperature)
        values = {f'rejected {reason}': count for reason, count in sorted(rejected.items())}
        for kind in _KINDS:
            values[f'received {kind}'] = self._taken[kind]
            values[f'{kind} in the last second'] = self._taken[kind] - self._taken_before[kind]
        values['joint_states of no joint of this robot'] = pipeline.passed_over
        values['temperatures known'] = f'{known.sum()} of {len(known)}'
        values |= {f'temperatures of {name!r}, no joint of this robot': count
                   for name, count in self._others.items()}
        before, self._taken_before = self._taken_before, Counter(self._taken)
        if not self._taken['joint_states']:
            return (*_MISSING, values)
        if self._taken['joint_states'] == before['joint_states']:
            return STALE, 'no joint states in the last second', values
        told = self._refused(pipeline)
        # Within the first second temperatures may just not have come yet.
        if before['joint_states']:
            told += self._missing_temperatures(pipeline.model, known)
        return (WARN, '; '.join(told), values) if told else (OK, 'joint states arrive', values)

    def _refused(self, pipeline):
        """Return sentences on the joint states that were not used."""
        rejected, newest = pipeline.rejected, pipeline.last_stamp
        # Messages with some of the joints are normal, as long as whole ones come too.
        newly = (sum(rejected.values()) - rejected.get('missing_joint', 0)
                 - self._rejected_before)
        self._rejected_before += newly
        stopped, self._newest_before = newest == self._newest_before, newest
        told = [f'{newly} inputs rejected in the last second'] if newly else []
        if newest is None:
            return [pipeline.why_none, *told]
        return told or ([_UNUSABLE] if stopped else [])

    def _missing_temperatures(self, model, known):
        """Return sentences, none where the model asks for no temperature or all are known."""
        if known.all() or not any(use.name in NEEDS_TEMPERATURE for use in model.uses):
            return []
        missing = [joint for joint, there in zip(model.robot.joints, known) if not there]
        told = [f'no temperature of {", ".join(missing)}: taken as unknown, intervals wider']
        if self._others:
            told.append(f'temperatures arrive of {", ".join(map(repr, self._others))}: frame_id '
                        'must be the name of a joint')
        return told
