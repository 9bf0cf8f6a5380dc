"""Run a Pipeline over a recording and tell the result as the estimate JSON of DESIGN section 4."""

import numpy as np

from .recording import TemperatureSample

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
    """Return the estimate of a Recording as plain JSON content; causal."""
    first, last, history, believed = None, -np.inf, _History(), None
    for item in recording.samples:
        if isinstance(item, TemperatureSample):
            pipeline.temperature_reading(item.joint, item.value)
            continue
        used = pipeline.samples
        estimate = pipeline.joint_state(item.stamp, item.names, item.position, item.velocity,
                                        item.effort)
        if pipeline.samples == used:
            continue
        first = item.stamp if first is None else first
        believed = estimate or believed
        # Rounded clocks make 20 ms a hair more than 20 ms.
        if item.stamp - last >= SPACING - 1e-3:
            last = item.stamp
            history.add(item.stamp - first, believed or pipeline.method.belief())
    final = pipeline.estimate(last)
    std = final.std
    return {
        'schema': SCHEMA, 'method': pipeline.method.name, 'status': final.status,
        'reason': final.reason, 'frame': pipeline.model.robot.load_frame,
        'mass': {'mean': float(final.mean[0]), 'std': float(std[0])},
        'com': {'mean': final.mean[1:4].tolist(), 'std': std[1:4].tolist()},
        'inertia': {'mean': final.mean[4:].tolist(), 'std': std[4:].tolist()},
        'covariance': final.covariance.tolist(), 'determined': final.determined.tolist(),
        'load_id': final.load_id, 'samples': pipeline.samples, 'rejected': pipeline.rejected,
        'history': history.content()}
