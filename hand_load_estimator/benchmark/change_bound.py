"""How soon torques tell a change of the load to a test that knows both loads."""

from ..estimators.change import EVIDENCE, FORETOLD
from ..torque.model_follower import ModelFollower


def earliest_seen(model, samples, at, change):
    """
    Return the stamp [s] of the MotionSample that brings the evidence asked of a change, or None.

    at [s]: when the load changes; change (10,): what its products change by. The expected log
    likelihood ratio of two known loads, with the variances that estimates count and as if the
    motion filter were not late, reaches the least that is asked of the evidence for an unknown
    one.
    """
    follower, told = ModelFollower(model), 0.0
    needed = FORETOLD * EVIDENCE / min(model.residuals.load_share, 1.0)
    for sample in samples:
        prediction = follower.update(sample)
        if sample.stamp < at:
            continue
        torque = prediction.load_columns @ change
        told += 0.5 * sample.dt * float((torque ** 2 / prediction.density).sum())
        if told >= needed:
            return sample.stamp
    return None
