"""The residual loop from recordings to a Diagnosis and a better torque model."""

from dataclasses import replace
import time

import numpy as np

from ..clipped_effort import clipped_efforts
from ..identification import prior
from ..recording_mark import refuse_repeats
from ..sliding import sliding_rms
from .add import better_model
from .another_robot import refuse_another_robot
from .another_state import of_another_state
from .contact import contact
from .correction import offered, with_correction
from .diagnosis import Diagnosis
from .disturbance import Disturbances, undisturbed
from .disturbance_findings import findings_again
from .few_temperatures import between_two_temperatures
from .find import find_residual
from .findings import findings_of, refuted
from .folds import only_suspected, repeated
from .impossible import on_wrong_footing
from .known_recordings import known_by_name_only, known_names, made_from
from .limits import (refuse_the_useless, slow_joint_states, still_joints, too_little_gained,
                     warmed_joints)
from .load_change import load_change
from .mostly_structure import mostly_structure
from .not_named import sentences_on
from .odd_recording import odd_recordings
from .rest import rest_of
from .spring_beside_cable import further_terms
from .standing import Standing
from .standing_diagnosis import diagnose_standing, only_stands
from .structure import structures
from .time_left import long_loads, many_rejected, refuse_too_short
from .trace import ROUNDS, Trace
from .unfounded import (faint_in, of_another_kind, small_beside_others, unsure_in,
                        without_unsure)
from .unknown import left_over, unexplained_joints, unknown_left

# Without recordings to test on, the last part of every recording is kept for that.
TEST_SHARE = 0.25


def diagnose(model, evidence, test=(), progress=lambda text: None):
    """
    Return (Diagnosis, better TorqueModel) of a TorqueModel and Evidence (evidence.prepare).

    test: Evidence that is used for nothing but the errors before and after; without any, the
    last quarter of every recording. Raises RecordingError where nothing can be told, and for
    recordings given twice.
    """
    began = time.monotonic()
    refuse_repeats(evidence, test)
    refuse_another_robot(model, test)
    kept = not test
    tested_on = ', '.join(e.name for e in test) or 'the last quarter of every recording'
    if only_stands(evidence):
        return diagnose_standing(model, evidence, lambda: time.monotonic() - began), model
    refuse_the_useless(model, evidence)
    progress('looking for contacts and changes of the load')
    whole, _ = _residual(model, evidence)
    outside = _outside(model, evidence, whole)
    names = tuple(e.name for e in evidence)
    seen = known_names(model, evidence if kept else test)
    by_name = known_by_name_only(model, [*evidence, *test])
    left_out = _left_out(evidence, whole, outside) if kept else 0.0
    told = _of_recordings(model.robot, evidence, test, whole, outside)
    left, test = _parts(evidence, whole, outside, test)
    refuse_too_short(left, evidence, whole, outside.found)
    recordings, evidence = evidence, left
    refuse_the_useless(model, evidence)
    warmed, sentences = warmed_joints(model, evidence)
    progress('computing the residual')
    residual, still = _residual(model, evidence)
    own = made_from(model, evidence)
    trace, rest = _traced(model, residual, warmed, own, progress)
    progress('estimating everything together')
    refitted = own and kept and bool(trace.steps or outside.found)
    old, better = _models(model, trace.steps, evidence, own and bool(outside.found), refitted)
    before, after, rest_of_test = _errors(old, better, test)
    again = _again(model, better, recordings, whole, outside.found)
    findings, doubts = _found((model, better), residual, (trace, rest),
                              (names, (whole, outside.found), again), (before, after))
    findings, between, state = _beyond_recordings(findings, model, residual, evidence)
    progress('telling where the residual lives')
    structure = structures(model, better, residual, evidence, warmed)
    cannot = [*state, *by_name, *told, *sentences, *slow_joint_states(evidence),
              *still.values(), *_unfinished(trace),
              *repeated(residual.cut, evidence, test),
              *odd_recordings(model, evidence, lambda parts: _sliding(better, parts)),
              *_nearly(model.robot, trace, findings, _structured(rest_of_test))]
    findings += mostly_structure(model.robot, residual, rest, findings, structure,
                                 trace.trials)
    correction = offered(better, findings, evidence,
                         lambda m: (_errors(old, m, test)[1], _sliding(m, test)))
    return with_correction(Diagnosis(
        model.robot.name, tuple(model.robot.joints), before, after, rest_of_test.noise, findings,
        rest_of_test.least_structure, tuple(cannot), recordings=names,
        tested_on=tested_on, seen=() if refitted else seen, refitted=refitted, left_out=left_out,
        seconds=time.monotonic() - began,
        remains=doubts + between + sentences_on(structure, model.robot.joints),
        structure=structure, sliding=_sliding(better, test), noise_most=rest_of_test.most,
        another_state=bool(state)), correction), better


def _of_recordings(robot, evidence, test, whole, outside):
    """Return sentences on what recordings are like, and how much of them says nothing."""
    return [*long_loads(evidence, whole, outside.found), *many_rejected(evidence),
            *clipped_efforts(robot, [*evidence, *test])]


def _models(model, steps, evidence, misled, seen):
    """
    Return TorqueModels: to compare with, and with what was found.

    misled: whether the model took what acted from outside for the arm's own; seen: whether it was
    made from what is now kept for the test.
    """
    if not steps and not misled:
        return model, model
    # Where another is written both are fitted without the test; else the error told is that of
    # the model written.
    old = better_model(model, (), evidence) if seen else model
    return old, better_model(model, steps, evidence)


def _found(models, residual, traced, outside, errors):
    """
    Return Findings with the verdicts that hold, and sentences on why some do not.

    models: diagnosed and better; traced: Trace and rest (N, n) [Nm]; outside: names of recordings,
    Residual of them whole and Disturbances, the same of the better model; errors: RMSE (n,) [Nm]
    of both models on the test.
    """
    (model, better), (trace, rest), joints = models, traced, models[0].robot.joints
    left = unexplained_joints(residual, rest)
    odd = left + trace.unexplained()
    once, gone = findings_again(model.robot, *outside, odd)
    findings = findings_of(model, better, trace, odd) + once \
        + unknown_left(model, residual, rest, left, trace)
    findings, doubts = refuted(findings, joints, *errors)
    findings, kinds = of_another_kind(findings, faint_in(model, better, trace))
    findings, unsure = without_unsure(findings, unsure_in(model, better, trace))
    findings, wrong = on_wrong_footing(findings, joints, model, better)
    findings, small = small_beside_others(findings)
    findings, further = further_terms(findings, model, residual)
    if residual.cut.shown is not None:
        findings = only_suspected(findings)
    return findings, wrong + kinds + unsure + small + further + doubts + gone


def _residual(model, evidence):
    """Return (Residual of usable rows, {joint index: why it tells nothing})."""
    still = still_joints(model, evidence)
    residual = find_residual(model, evidence)
    weights = residual.weights.copy()
    weights[:, list(still)] = 0.0
    return replace(residual, weights=weights), still


def _outside(model, evidence, residual):
    """Return the Outside of whole recordings."""
    return Standing(model, evidence, residual).beside(_in_motion(model, evidence, residual))


def _in_motion(model, evidence, residual, known=()):
    """Return the Disturbances of an arm that moves; known: as of those."""
    loads = tuple(e.load for e in evidence)
    return Disturbances(model, residual, (contact(model.robot, residual),
                                          load_change(model.robot, residual, loads)), known)


def _again(model, better, evidence, whole, found):
    """Return Residual and Disturbances of whole recordings, `found` once more by the better."""
    known = tuple(one for one in found if np.isfinite(one.evidence))
    if model is better or not known:
        return whole, found
    residual, _ = _residual(better, evidence)
    return residual, _in_motion(better, evidence, residual, known).found


def _outside_rows(evidence, residual, outside):
    """Return for each recording the rows (M,) bool in which something acted from outside."""
    return [outside.rows[residual.owner == k] for k in range(len(evidence))]


def _left_out(evidence, residual, outside):
    """Return the time [s] in which something acted from outside in the part kept for the test."""
    seconds = 0.0
    for e, rows in zip(evidence, _outside_rows(evidence, residual, outside)):
        done = np.cumsum(~rows) / max(np.sum(~rows), 1)
        seconds += float(e.motion.dt[rows & (done > 1.0 - TEST_SHARE)].sum())
    return seconds


def _parts(evidence, residual, outside, test):
    """Return (Evidence to fit, Evidence to test on) without what acted from outside."""
    rows = _outside_rows(evidence, residual, outside)
    last = 1.0 if test else 1.0 - TEST_SHARE

    def parts(share):
        return tuple(part for e, r in zip(evidence, rows) for part in undisturbed(e, r, share))
    return parts((0.0, last)), tuple(test) or parts((last, 1.0))


def _traced(model, residual, warmed, own, progress):
    """Return (Trace, what is left (N, n))."""
    trace = Trace(model, residual, warmed, _root(model) if own else None, progress)
    trace.run()
    trace.keep_what_still_gains()
    return trace, left_over(model.robot, trace.blocks)


def _root(model):
    """Return the square root (P, P) of what parameters may be before any recording."""
    return np.sqrt(prior(model.robot, model.uses, model.links_declared)[1])


def _errors(model, better, test):
    """Return RMSE (n,) [Nm] of both models on test data while joints slide, Rest of the new."""
    old, new = (errors_of(m, test) for m in (model, better))
    # Each model knows its friction state at other times; both are judged at the same.
    known = np.isfinite(old + new)
    # Nor at joints that a contact or the arm's own shaking moves for a moment.
    known[:, list(still_joints(better, test))] = False
    old, new = (np.where(known, e, np.nan) for e in (old, new))
    rest = rest_of(new, np.concatenate([e.motion.dt for e in test]),
                   np.concatenate([e.motion.messages for e in test]),
                   np.concatenate([np.full(len(e.motion.dt), k) for k, e in enumerate(test)]))
    return _rms(old), rest.rms, rest


def _sliding(model, test):
    """Return what a model leaves of test data while joints slide (n,) [Nm]."""
    residual = find_residual(model, test, cut=False)
    sliding = residual.sliding.copy()
    sliding[:, list(still_joints(model, test))] = False
    return sliding_rms(residual.residual, sliding, residual.dt, residual.owner)


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


def _beyond_recordings(findings, model, residual, evidence):
    """Return Findings that recordings of these temperatures, and of this arm, can confirm; why."""
    findings, between = between_two_temperatures(findings, model.robot.joints, evidence)
    findings, state = of_another_state(findings, model, residual)
    return findings, between, state


def _unfinished(trace):
    """Return the sentence on a search that its last round did not end."""
    return [f'cannot tell whether there are more than {len(trace.steps)} effects because the '
            f'search ends after {ROUNDS} rounds; diagnose again with the model written'
            ] if trace.unfinished else []


def _structured(rest):
    """Return the indices of joints of whose error the larger part may be no noise."""
    return [int(j) for j in np.flatnonzero(rest.rms > 1.5 * rest.noise)]


def _nearly(robot, trace, findings, joints):
    """Return why nothing is named at joints with structure, where an effect nearly was."""
    named = {name for finding in findings for name in finding.joints}
    return too_little_gained(robot, trace.nearly, trace.needed,
                             [j for j in joints if robot.joints[j] not in named])
