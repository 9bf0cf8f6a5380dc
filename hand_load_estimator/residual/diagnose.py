"""The residual loop from recordings to a Diagnosis and a better torque model."""

from dataclasses import replace
import time

import numpy as np

from ..identification import Evidence as Recorded
from ..motion import Motion
from .add import better_model
from .diagnosis import Diagnosis
from .find import find_residual
from .findings import findings_of
from .limits import refuse_the_useless, saturated_rows, still_joints, temperatures_tell
from .trace import Trace

# Without recordings to test on, the last part of every recording is kept for that.
TEST_SHARE = 0.25
# Filtered white noise differs from its neighbour 20 ms later by so many of its variances.
NEIGHBOURS = 2.0 * (1.0 - 0.587)


def diagnose(model, evidence, test=(), progress=lambda text: None):
    """
    Return (Diagnosis, better TorqueModel) of a TorqueModel and Evidence (identification.prepare).

    test: Evidence that is used for nothing but the errors before and after; without any, the
    last quarter of every recording. Raises RecordingError where nothing can be told.
    """
    began = time.monotonic()
    refuse_the_useless(model, evidence)
    tested_on = ', '.join(e.name for e in test)
    if not test:
        evidence, test = zip(*(_split(e) for e in evidence))
        tested_on = 'the last quarter of every recording'
    told, sentence = temperatures_tell(evidence)
    still = still_joints(model, evidence)
    saturated, sentences = saturated_rows(model, evidence)
    progress('computing the residual')
    residual = find_residual(model, evidence)
    weights = np.where(saturated, 0.0, residual.weights)
    weights[:, list(still)] = 0.0
    residual = replace(residual, weights=weights)
    trace = Trace(model, residual, told, progress)
    trace.run()
    progress('estimating everything together')
    better = better_model(model, trace.steps, evidence) if trace.steps else model
    before, after, floor = _errors(model, better, test)
    findings = findings_of(model, better, residual, trace, before, after)
    cannot = [s for s in (sentence, *still.values(), *sentences) if s]
    return Diagnosis(
        model.robot.name, tuple(model.robot.joints), before, after, floor, findings,
        _unexplained(after, floor), tuple(cannot), recordings=tuple(e.name for e in evidence),
        tested_on=tested_on, seconds=time.monotonic() - began,
        remains=_remains(model.robot, after, floor)), better


def _split(recorded):
    """Return (fitting part, test part) of one Evidence."""
    motion = recorded.motion
    at = int((1.0 - TEST_SHARE) * len(motion.stamp))

    def part(rows):
        return Recorded(recorded.name, Motion(*(getattr(motion, name)[rows] for name in
                                                Motion.__dataclass_fields__)),
                        recorded.torque[rows])
    return part(slice(0, at)), part(slice(at, None))


def _errors(model, better, test):
    """Return RMSE (n,) [Nm] of both models on test data while joints slide, and its noise floor."""
    old, new = (find_errors(m, test) for m in (model, better))
    floor = np.sqrt(np.mean(np.diff(new, axis=0) ** 2, axis=0) / NEIGHBOURS)
    before, after = (np.sqrt(np.mean(e ** 2, axis=0)) for e in (old, new))
    return before, after, np.minimum(floor, after)


def find_errors(model, evidence):
    """Return tau_real - tau_mdl (N, n) [Nm], 0 where a joint's friction state is not known."""
    residuals = [find_residual(model, [e], cut=False) for e in evidence]
    moving = np.concatenate([r.moving for r in residuals])
    errors = np.concatenate([r.residual for r in residuals])
    share = np.sqrt(np.maximum(moving.mean(axis=0), 1e-9))
    # The mean over all rows is then the mean over the moving ones.
    return np.where(moving, errors / share, 0.0)


def _unexplained(after, floor):
    return np.clip(1.0 - (floor / np.maximum(after, 1e-12)) ** 2, 0.0, 1.0)


def _remains(robot, after, floor):
    return tuple(
        f'{robot.joints[j]}: {after[j]:.2f} Nm are left, {floor[j]:.2f} Nm of them noise'
        for j in range(robot.n) if after[j] > 1.5 * floor[j])
