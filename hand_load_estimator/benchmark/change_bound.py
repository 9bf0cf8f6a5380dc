"""The earliest that torques tell a change of the load, to a test that knows both loads."""

from ..estimators.change import EVIDENCE
from ..torque.model_follower import ModelFollower


def earliest_seen(model, samples, at, change):
    """
    Return the stamp [s] of the MotionSample that brings the evidence asked of a change, or None.

    at [s]: when the load changes; change (10,): what its products change by. The expected log
    likelihood ratio of two known loads, by the noise that the torque model states and with
    friction as the model has it, reaches EVIDENCE: a test that knows neither load needs longer.
    """
    follower, told = ModelFollower(model), 0.0
    for sample in samples:
        prediction = follower.update(sample)
        if sample.stamp < at:
            continue
        torque = prediction.load_columns @ change
        variance = prediction.density / sample.dt + prediction.noise
        told += 0.5 * float((torque ** 2 / variance).sum())
        if told >= EVIDENCE:
            return sample.stamp
    return None
