"""Run a Pipeline over a recording and tell the result as the estimate JSON of DESIGN section 4."""

import numpy as np

from ..recording import TemperatureSample
from ..stream.arm_names import refuse_several

SCHEMA = 'hand_load/estimate/1'
# Spacing of history entries [s] where the messages themselves are closer.
SPACING = 0.02


class _History:
    """What was believed when; always finite, the prior before any data."""

    def __init__(self):
        self.rows = []

    def add(self, t, belief):
        """Note a Belief or LoadEstimate at t [s] from the first sample."""
        std = np.sqrt(np.diag(belief.covariance))
        self.rows.append((t, belief.mean[0], std[0], belief.mean[1:4], std[1:4]))

    def content(self):
        """Return the mapping of the schema."""
        t, mass, mass_std, com, com_std = zip(*self.rows) if self.rows else ((),) * 5
        return {'t': _plain(t), 'mass': _plain(mass), 'mass_std': _plain(mass_std),
                'com': _plain(com), 'com_std': _plain(com_std)}


def _plain(values):
    return np.round(np.array(values, dtype=float), 6).tolist()


def estimate_recording(pipeline, recording):
    """
    Return the estimate of a Recording as plain JSON content; causal.

    Raises RecordingError for one of several arms alike.
    """
    # time goes on from where it was when the clock of a looped recording restarts
    time, stamp, last, history, believed = 0.0, None, -np.inf, _History(), None
    for item in recording.samples:
        if isinstance(item, TemperatureSample):
            pipeline.temperature_reading(item.joint, item.value)
            continue
        used = pipeline.samples
        estimate = pipeline.joint_state(item.stamp, item.names, item.position, item.velocity,
                                        item.effort)
        if pipeline.samples == used:
            continue
        time += 0.0 if stamp is None else max(item.stamp - stamp, 0.0)
        stamp = item.stamp
        believed = estimate or believed
        # Half the spacing, so that the message after the next is not needed to keep it.
        if time - last >= 0.5 * SPACING - 1e-4:
            last = time
            history.add(time, believed or pipeline.method.belief())
    refuse_several(pipeline.names, recording.path)
    # What could not be used at the end counts: the load may be another one by then.
    final = pipeline.estimate(0.0 if stamp is None else pipeline.last_stamp)
    std = final.std
    return {
        'schema': SCHEMA, 'method': pipeline.method.name, 'intervals': pipeline.intervals,
        'status': final.status, 'reason': final.reason, 'frame': pipeline.model.robot.load_frame,
        'mass': {'mean': float(final.mean[0]), 'std': float(std[0])},
        'com': {'mean': final.mean[1:4].tolist(), 'std': std[1:4].tolist()},
        'inertia': {'mean': final.mean[4:].tolist(), 'std': std[4:].tolist()},
        'covariance': final.covariance.tolist(), 'determined': final.determined.tolist(),
        'load_id': final.load_id, 'tool_mass': pipeline.tool_mass,
        'samples': pipeline.samples, 'rejected': pipeline.rejected,
        'history': history.content()}
