"""Are joint temperatures there, for every joint, in degC."""

import numpy as np

from .finding import DOUBT, Finding, OK, WRONG

# [degC] where an arm in a factory can be.
_COLDEST, _HOTTEST, _KELVIN = -20.0, 90.0, 200.0
_RARELY_ABOVE = 60.0
_JUMP = 5.0  # [K] no sensor changes so much from one reading to the next


def check_temperatures(recording, joints):
    """Return the findings about joint temperatures."""
    samples = recording.temperature_samples
    if not samples:
        return [Finding('temperatures', DOUBT, 'none in the recording', 'the model then assumes '
                        'its reference temperature with a wider variance; warm the arm up or '
                        'publish joint_temperatures')]
    readings = {joint: [s for s in samples if s.joint.endswith(joint)] for joint in joints}
    return [_presence(readings), _plausibility(readings)]


def _presence(readings):
    missing = [joint for joint, samples in readings.items() if not samples]
    if missing:
        return Finding('temperatures', WRONG if len(missing) == len(readings) else DOUBT,
                       f'none for {", ".join(missing)}', 'header.frame_id must be the joint name')
    counts = [len(samples) for samples in readings.values()]
    stamps = [s.stamp for samples in readings.values() for s in samples]
    rate = (min(counts) - 1) / max(max(stamps) - min(stamps), 1e-9)
    return Finding('temperatures', OK if rate > 0.1 else DOUBT,
                   f'all {len(readings)} joints, {rate:.1f} Hz each', '' if rate > 0.1 else
                   'about 10 Hz is normal')


def _plausibility(readings):
    joints = [np.array([s.value for s in samples]) for samples in readings.values()]
    values = np.concatenate(joints)
    finite = values[np.isfinite(values)]
    if not len(finite):
        return Finding('temperature unit', WRONG, 'no finite value', 'publish degC')
    low, high = finite.min(), finite.max()
    text = f'{low:.1f} to {high:.1f}'
    if low > _KELVIN:
        return Finding('temperature unit', WRONG, text, 'looks like kelvin; publish degC')
    if not finite.any():
        return Finding('temperature unit', DOUBT, 'all exactly zero', 'they count as none; a '
                       'missing temperature must be NaN or not be sent')
    if any(_zero_for_missing(v[np.isfinite(v)], finite) for v in joints if 0.0 in v):
        return Finding('temperature unit', WRONG, f'{text}, with zeros', 'a missing temperature '
                       'must be NaN or not be sent')
    if low < _COLDEST or high > _HOTTEST:
        return Finding('temperature unit', WRONG, text, 'not the degC of an arm')
    suspect = np.median(finite) > _RARELY_ABOVE
    missing = len(values) - len(finite)
    return Finding('temperature unit', DOUBT if suspect else OK,
                   f'{text} degC, {missing} not finite', 'looks like degF, or the arm is very hot'
                   if suspect else '')


def _zero_for_missing(joint, all_joints):
    """Tell whether zeros in a joint's values (N,) stand far from their neighbours in time."""
    zeros, others = np.flatnonzero(joint == 0.0), np.flatnonzero(joint)
    if not len(others):
        return np.median(np.abs(all_joints[all_joints != 0.0])) > _JUMP
    after = np.searchsorted(others, zeros)
    near = np.abs(joint[others[[np.maximum(after - 1, 0), np.minimum(after, len(others) - 1)]]])
    return bool(np.any(near.min(axis=0) > _JUMP))
