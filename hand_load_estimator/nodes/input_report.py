"""What /diagnostics says of the input: what arrives, what is refused, what is not known."""

from collections import Counter

import numpy as np

from ..effects import NEEDS_TEMPERATURE
from ..stream.frozen import told_of_frozen
from ..stream.joint_temperatures import joint_index
from .diagnostics import ERROR, OK, STALE, WARN

_KINDS = ('joint_states', 'temperatures')
_MISSING = (ERROR, 'no joint states have arrived')
_UNUSABLE = ('no usable joint state in the last second: those that arrive do not name all joints '
             'of this robot')
# Names of others that are told one by one; a driver that invents names must not fill the memory.
_MOST_NAMES = 10


# Joint states per second of their stamps that everything is measured with, and a little beyond,
# where the stamps tell of at least and at most so many [s].
_FEWEST, _MOST, _SPAN, _LONGEST = 25, 1200, 0.3, 10.0


def _other_arms(arm):
    """Return [a sentence] where ArmNames told this arm from others by who came first, or []."""
    if not (arm.prefix and arm.others):
        return []
    others = ', '.join(map(repr, sorted(arm.others)))
    return [f'joint states of more arms than one: those behind {arm.prefix!r} are used, those '
            f'behind {others} are not; name the joints in the robot file with their prefix']


def _other_temperatures(used, others, pipeline):
    """Return [a sentence] where temperatures of several arms are told apart by who came first."""
    prefix = pipeline.names.prefix or ''
    own = {prefix + joint for joint in pipeline.model.robot.joints}
    if not others or set(used) <= own:
        return []
    return [f'temperatures of more arms than one: of {", ".join(set(used) - own)} they came first '
            f'and are used, of {", ".join(others)} they are not; name them as the joint states do']


def _velocities(stuck, joints):
    """Return [a sentence] where velocities are no measurements, or []; stuck (n,) of joints."""
    named = [joint for joint, own in zip(joints, stuck) if own]
    if not named:
        return []
    which = 'velocities are all' if len(named) == len(joints) else \
        f'the velocity of {", ".join(named)} is'
    return [f'{which} zero while the arm moves: velocities are taken from the positions']


def _rate(count, seconds):
    """Return [a sentence] on joint states too few or too many for so many seconds, or []."""
    # Stamps that go on for longer than a report's second have jumped, or time is simulated.
    if not _SPAN <= seconds <= _LONGEST or _FEWEST <= count / seconds <= _MOST:
        return []
    return [f'joint states come at {count / seconds:.0f} Hz: made for 30 to 1000']


class InputReport:
    """
    Counts messages and tells of them once a second.

    A model with temperature effects came from an arm whose temperatures were measured, so that
    their absence is a fault; the model of an arm without sensors has no such effect, and nothing
    is asked of it.
    """

    def __init__(self):
        self._taken, self._taken_before, self._rejected_before = Counter(), Counter(), 0
        self._others, self._newest_before, self._others_before = Counter(), None, 0

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
        used, _ = pipeline.temperature_names
        values['temperatures are taken from'] = ', '.join(used) or 'none'
        values['temperatures known'] = f'{known.sum()} of {len(known)}'
        values |= {f'temperatures of {name!r}, no joint of this robot': count
                   for name, count in self._others.items()}
        before, self._taken_before = self._taken_before, Counter(self._taken)
        if not self._taken['joint_states']:
            return (*_MISSING, values)
        if self._taken['joint_states'] == before['joint_states']:
            self._newest_before = None
            return STALE, 'no joint states in the last second', values
        rate = self._rate(pipeline, self._taken['joint_states'] - before['joint_states'])
        told = [*self._refused(pipeline), *_other_arms(pipeline.names),
                *_other_temperatures(*pipeline.temperature_names, pipeline),
                *told_of_frozen(pipeline.frozen),
                *_velocities(pipeline.velocity_stuck, pipeline.model.robot.joints), *rate]
        # Within the first second temperatures may just not have come yet.
        if before['joint_states']:
            told += self._missing_temperatures(pipeline.model, known)
        return (WARN, '; '.join(told), values) if told else (OK, 'joint states arrive', values)

    def _refused(self, pipeline):
        """Return sentences on the joint states that were not used."""
        rejected, newest = pipeline.rejected, pipeline.last_stamp
        # Messages with some of the joints are normal, as long as whole ones come too.
        # Temperatures of zero are told of where they are missed.
        newly = (sum(rejected.values()) - rejected.get('missing_joint', 0)
                 - rejected.get('zero_temperature', 0) - self._rejected_before)
        self._rejected_before += newly
        stopped, self._newest_before = newest == self._newest_before, newest
        told = [f'{newly} inputs rejected in the last second'] if newly else []
        if newest is None:
            return [pipeline.why_none, *told]
        return told or ([_UNUSABLE] if stopped else [])

    def _rate(self, pipeline, count):
        """Return what _rate says of `count` joint states, the others' among them."""
        others, before = pipeline.passed_over, self._newest_before
        count -= others - self._others_before
        self._others_before = others
        newest = pipeline.last_stamp
        return [] if None in (newest, before) else _rate(count, newest - before)

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
