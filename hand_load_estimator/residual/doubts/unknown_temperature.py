"""Where no temperature was recorded, friction as of another one is no effect of unknown kind."""

from dataclasses import replace

import numpy as np

from ...effects import NEEDS_TEMPERATURE
from ..diagnosis import SUSPECTED, UNKNOWN
from ..tracing.trace import UNEXPECTED
from .unknown import rms_of


def lacks_temperature(model, evidence):
    """Tell of which joints (n,) friction depends on a temperature that Evidence does not have."""
    depends = {use.joint for use in model.uses if use.name in NEEDS_TEMPERATURE}
    return np.isnan(evidence.motion.temperature).any(axis=0) \
        & np.isin(np.arange(model.robot.n), list(depends))


def within_unknown_temperature(model, evidence, residual, rest):
    """
    Return (n,) bool: all that is left there may be friction as of a temperature not recorded.

    rest (N, n) [Nm]: what is left of the Residual of Evidence after everything found, against
    what the TorqueModel says to expect.
    """
    left = rms_of(rest, residual.moving & (residual.weights > 0.0))
    lacks = np.any([lacks_temperature(model, e) for e in evidence], axis=0)
    return lacks & (left < UNEXPECTED * residual.expected)


def without_unknown_temperature(findings, joints, within):
    """
    Return (Findings, sentences): suspected `unknown` effects only where they are more than that.

    joints: names (n,); within (n,) bool: as of within_unknown_temperature.
    """
    may, kept, told = {name for name, w in zip(joints, within) if w}, [], []
    for finding in findings:
        if finding.name == UNKNOWN and finding.verdict == SUSPECTED:
            told += [name for name in finding.joints if name in may]
            finding = replace(finding, joints=tuple(n for n in finding.joints if n not in may))
        if finding.joints:
            kept.append(finding)
    return tuple(kept), [
        f'cannot tell whether there is anything unknown at {", ".join(told)} because without '
        'temperatures what is left there may be friction as of another one'] if told else []
