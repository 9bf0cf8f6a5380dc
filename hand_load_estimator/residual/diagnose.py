"""The residual loop from recordings to a Diagnosis and a better torque model."""

from dataclasses import replace
import time

import numpy as np

from ..identification import Evidence as Recorded, prior
from ..motion import Motion
from .add import better_model, made_from
from .correction import offered, with_correction
from .diagnosis import UNKNOWN, Diagnosis
from .contact import contacts_in
from .find import find_residual, noise_floor
from .findings import findings_of
from .limits import (refuse_another_robot, refuse_the_useless, saturated_rows, still_joints,
                     warmed_joints)
from .trace import Trace
from .unknown import left_over, unexplained_joints, unknown_left

# Without recordings to test on, the last part of every recording is kept for that.
TEST_SHARE = 0.25


def diagnose(model, evidence, test=(), progress=lambda text: None):
    """
    Return (Diagnosis, better TorqueModel) of a TorqueModel and Evidence (identification.prepare).

    test: Evidence that is used for nothing but the errors before and after; without any, the
    last quarter of every recording. Raises RecordingError where nothing can be told.
    """
    began = time.monotonic()
    refuse_another_robot(model, test)
    tested_on = ', '.join(e.name for e in test)
    kept = not test
    if kept:
        evidence, test = zip(*(_split(e) for e in evidence))
        tested_on = 'the last quarter of every recording'
    refuse_the_useless(model, evidence)
    warmed, sentences = warmed_joints(model, evidence)
    still = still_joints(model, evidence)
    saturated, limited = saturated_rows(model, evidence)
    progress('computing the residual')
    residual = find_residual(model, evidence)
    weights = np.where(saturated, 0.0, residual.weights)
    weights[:, list(still)] = 0.0
    residual = replace(residual, weights=weights)
    own = made_from(model, evidence)
    trace, rest, events, contacts = _traced(model, residual, warmed, own, progress)
    progress('estimating everything together')
    better = better_model(model, trace.steps, evidence) if trace.steps else model
    # A model made from these recordings has seen what is now kept for the test.
    old = better_model(model, (), evidence) if own and kept else model
    before, after, floor = _errors(old, better if trace.steps else old, test)
    left = unexplained_joints(model, residual, rest, events)
    odd = left + tuple(j for step in trace.steps if step.chosen.name == UNKNOWN
                       for j in step.chosen.joints)
    # Bursts of what goes on all the time are no contacts.
    contacts = () if odd else contacts
    findings = findings_of(model, better, residual, trace, odd) \
        + contacts + unknown_left(model, residual, rest, left, trace)
    cannot = [*sentences, *still.values(), *limited]
    correction = offered(better, findings, evidence, lambda m: _errors(old, m, test)[1])
    return with_correction(Diagnosis(
        model.robot.name, tuple(model.robot.joints), before, after, floor, findings,
        _unexplained(after, floor), tuple(cannot), recordings=tuple(e.name for e in evidence),
        tested_on=tested_on, seconds=time.monotonic() - began,
        remains=_remains(model.robot, after, floor)), correction), better


def _traced(model, residual, warmed, own, progress):
    """Return (Trace, what is left (N, n), rows of contacts, Findings on them)."""
    root = _root(model) if own else None
    for _ in range(2):
        trace = Trace(model, residual, warmed, root, progress)
        trace.run()
        trace.keep_what_still_gains()
        rest = left_over(model, residual, trace.blocks)
        events, contacts = contacts_in(model.robot, residual, rest, trace.trials)
        if not (contacts and trace.steps):
            break
        # A contact must not pass for an effect of the arm: once more without it.
        residual = replace(residual, weights=np.where(events[:, None], 0.0, residual.weights))
    return trace, rest, events, contacts


def _root(model):
    """Return the square root (P, P) of what parameters may be before any recording."""
    return np.sqrt(prior(model.robot, model.uses, model.links_declared)[1])


def _split(recorded):
    """Return (fitting part, test part) of one Evidence."""
    motion = recorded.motion
    at = int((1.0 - TEST_SHARE) * len(motion.stamp))

    def part(rows):
        return Recorded(recorded.name, Motion(*(getattr(motion, name)[rows] for name in
                                                Motion.__dataclass_fields__)),
                        recorded.torque[rows],
                        None if recorded.held is None else recorded.held[rows])
    return part(slice(0, at)), part(slice(at, None))


def _errors(model, better, test):
    """Return RMSE (n,) [Nm] of both models on test data while joints slide, noise floor."""
    old, new = (errors_of(m, test) for m in (model, better))
    # Each model knows its friction state at other times; both are judged at the same.
    old, new = (np.where(np.isfinite(old + new), e, np.nan) for e in (old, new))
    floor = noise_floor(new)
    before, after = _rms(old), _rms(new)
    return before, after, np.minimum(floor, after)


def _rms(errors):
    """Return the RMS (n,) of what is known in (N, n); NaN for a joint that never slides."""
    known = np.isfinite(errors)
    count = known.sum(axis=0)
    squares = np.where(known, errors ** 2, 0.0).sum(axis=0)
    return np.sqrt(np.where(count > 0, squares / np.maximum(count, 1), np.nan))


def errors_of(model, evidence):
    """Return tau_real - tau_mdl (N, n) [Nm], NaN where a joint does not surely slide."""
    residuals = [find_residual(model, [e], cut=False) for e in evidence]
    return np.concatenate([np.where(r.moving, r.residual, np.nan) for r in residuals])


def _unexplained(after, floor):
    return np.clip(1.0 - (floor / np.maximum(after, 1e-12)) ** 2, 0.0, 1.0)


def _remains(robot, after, floor):
    return tuple(
        f'{robot.joints[j]}: {after[j]:.2f} Nm are left, {floor[j]:.2f} Nm of them noise'
        for j in range(robot.n) if after[j] > 1.5 * floor[j])
