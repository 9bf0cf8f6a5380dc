"""Is a recording what the robot file says it is? Puts the checks together."""

from dataclasses import asdict, dataclass

import numpy as np

from ..errors import RecordingError
from ..load import LoadParameters
from ..recording import arrays
from ..stream.arm_names import ArmNames, refuse_several
from .effort import check_effort
from .finding import Finding, OK, UNKNOWN, WRONG
from .motion import check_motion, check_position, check_updates, check_values, check_velocity
from .signals import even_signals
from .stamps import check_stamps
from .temperatures import check_temperatures

SCHEMA = 'hand_load/check/1'
# More than this many times max_torque is no unit's, and sums of its squares are no numbers.
_NO_EFFORT = 1e12


@dataclass(frozen=True)
class RecordingCheck:
    """findings, a list of Finding; joints: {name: numbers of the effort's comparison}."""

    recording: str
    robot: str
    findings: list
    joints: dict

    def to_dict(self):
        """Return what --json prints."""
        return {'schema': SCHEMA, 'recording': self.recording, 'robot': self.robot,
                'findings': [asdict(f) for f in self.findings], 'joints': self.joints}


def _joints(recording, robot, found):
    samples = recording.joint_samples
    text = f'all {robot.n} in {found} of {len(samples)} messages'
    arm = ArmNames(robot.joints)
    for sample in samples:
        arm.index(sample.names, sample.stamp)
    try:
        refuse_several(arm, text)
    except RecordingError as error:
        return Finding('joints', WRONG, *str(error).split('; '))
    if found:
        return Finding('joints', OK, text)
    seen = sorted({name for s in samples for name in s.names})
    missing = [joint for joint in robot.joints if joint not in seen]
    return Finding('joints', WRONG, f'{text}; missing: {", ".join(missing)}; in the recording: '
                   f'{", ".join(seen) or "none"}', 'correct `joints` in the robot file, or choose '
                   'the topic with --joint-states')


def _known_load(recording, robot):
    """Return the load in the hand, its centre of mass guessed where only the mass is stated."""
    load = recording.load
    if load is None or load.mass == 0.0 or 'com' in recording.load_known:
        return load
    return LoadParameters(load.mass, robot.rated_load.com, load.inertia)


def _check_signals(recording, robot, time, position, velocity, effort):
    """Return the findings that need an even piece of data, and the table of joints."""
    if not np.isfinite(effort).any():
        return [Finding('effort', WRONG, 'none in the messages', 'have the driver publish it')], {}
    whole = np.isfinite(effort).all(axis=1)
    signals = even_signals(time[whole], position[whole], velocity[whole],
                           effort[whole] * robot.effort.torque_constants)
    if signals is None:
        return [Finding('effort', UNKNOWN, 'no piece of 4 s without a gap', 'record longer')], {}
    findings = [check_motion(signals, robot), check_velocity(signals, robot)]
    effort_findings, joints = check_effort(signals, robot, _known_load(recording, robot))
    return findings + effort_findings, joints


def check_recording(recording, robot):
    """Return the RecordingCheck of a Recording for a Robot; bad data becomes a finding."""
    time, position, velocity, effort = arrays(recording, robot.joints)
    most = _NO_EFFORT * robot.limits.torque / np.abs(robot.effort.torque_constants)
    effort = np.where(np.abs(effort) > most, np.nan, effort)
    findings, table = [_joints(recording, robot, len(time))], {}
    if len(time):
        findings += check_stamps(time)
        findings.append(check_values(recording, position, velocity, effort))
        findings.append(check_updates(position, velocity, effort))
        if np.isfinite(position).any():
            findings.append(check_position(position, robot))
            more, table = _check_signals(recording, robot, time, position, velocity, effort)
            findings += more
    findings += check_temperatures(recording, robot.joints)
    return RecordingCheck(str(recording.path), robot.name, findings, table)
