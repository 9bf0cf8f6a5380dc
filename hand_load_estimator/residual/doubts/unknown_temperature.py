"""Where no temperature was recorded, friction as of another one is no effect of unknown kind."""

from dataclasses import replace

import numpy as np

from ...effects import NEEDS_TEMPERATURE
from ..diagnosis import SUSPECTED, UNKNOWN
from ..pictures_left import pictures_left
from ..tracing.trace import UNEXPECTED
from .unknown import rms_of


def lacks_temperature(model, evidence):
    """Tell of which joints (n,) friction depends on a temperature that Evidence never has."""
    depends = {use.joint for use in model.uses if use.name in NEEDS_TEMPERATURE}
    return ~np.isfinite(evidence.motion.temperature).any(axis=0) \
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


def without_unknown_temperature(findings, robot, within, residual, rest):
    """
    Return (Findings, sentences): suspected `unknown` effects only where they are more than that.

    within (n,) bool: as of within_unknown_temperature; residual, rest: as there.
    """
    kept, told = [], []
    for finding in findings:
        if finding.name == UNKNOWN and finding.verdict == SUSPECTED:
            joints = [robot.joints.index(name) for name in finding.joints]
            more = [j for j in joints if not within[j]]
            told += [robot.joints[j] for j in joints if within[j]]
            finding = finding if more == joints else _of(finding, robot, more, residual, rest)
        kept += [finding] if finding else []
    return tuple(kept), [
        f'cannot tell whether there is anything unknown at {", ".join(told)} because without '
        'temperatures what is left there may be friction as of another one'] if told else []


def _of(finding, robot, joints, residual, rest):
    """Return a Finding of some of its joints (indices) only, None of none."""
    if not joints:
        return None
    rms = rms_of(rest, residual.moving)[joints]
    return replace(finding, joints=tuple(robot.joints[j] for j in joints),
                   evidence=replace(finding.evidence, rms=float(rms.max())),
                   pictures=pictures_left(robot, residual, rest, joints[int(rms.argmax())],
                                          finding.variables))
