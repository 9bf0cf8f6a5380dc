"""The residual loop from recordings to a Diagnosis and a better torque model."""

import time

import numpy as np

from ..files.recording_mark import refuse_repeats
from ..identification.clipped_effort import clipped_efforts
from ..torque.sliding import sliding_rms
from .add import better_model
from .correction import offered, with_correction
from .diagnosis import Diagnosis
from .doubts.another_robot import refuse_another_robot
from .doubts.another_state import of_another_state
from .doubts.as_expected import expected_changes
from .doubts.few_temperatures import between_two_temperatures
from .doubts.impossible import on_wrong_footing
from .doubts.known_recordings import known_by_name_only, known_names
from .doubts.limits import (noisier_recordings, refuse_the_useless, slow_joint_states,
                            still_joints, too_little_gained)
from .doubts.mostly_structure import drifting, mostly_structure
from .doubts.moved_zero import moved_zero
from .doubts.not_named import sentences_on
from .doubts.odd_recording import odd_recordings
from .doubts.spring_beside_cable import further_terms
from .doubts.temperatures_not_felt import not_felt
from .doubts.time_left import long_loads, many_rejected
from .doubts.unfounded import (faint_in, of_another_kind, small_beside_others, unsure_in,
                               without_unsure)
from .doubts.unknown import unexplained_joints, unknown_left
from .doubts.unknown_temperature import (within_unknown_temperature,
                                         without_unknown_temperature)
from .explanation import explain
from .findings import findings_of, refuted
from .measured.find import find_residual
from .measured.folds import only_suspected, repeated
from .measured.rest import rest_of
from .measured.structure import structures
from .outside.disturbance_findings import findings_again
from .outside.standing_diagnosis import diagnose_standing, only_stands
from .stated_shapes import with_stated_shapes
from .tracing.effort_filter import without_filters
from .tracing.saturating import gains_in_doubt
from .tracing.soft_end import soft_end_doubts
from .tracing.trace import ROUNDS


def diagnose(model, evidence, test=(), progress=lambda text: None):
    """
    Return (Diagnosis, better TorqueModel) of a TorqueModel and Evidence (evidence.prepare).

    test: Evidence that is used for nothing but the errors before and after, what they say against
    an effect (refuted), and whether it is of the same arm; without any, the last quarter of every
    recording. Raises RecordingError where nothing can be told, and for recordings given twice.
    """
    began = time.monotonic()
    refuse_repeats(evidence, test)
    refuse_another_robot(model, test)
    kept = not test
    tested_on = ', '.join(e.name for e in test) or 'the last quarter of every recording'
    if only_stands(evidence):
        return diagnose_standing(model, evidence, lambda: time.monotonic() - began), model
    refuse_the_useless(model, evidence)
    ex = explain(model, evidence, test, progress)
    told = _of_recordings(model.robot, evidence, test, ex)
    seen = known_names(model, evidence if kept else test)
    by_name = known_by_name_only(model, [*evidence, *test])
    left_out = ex.outside.left_out(evidence, ex.whole) if kept else 0.0
    names = tuple(e.name for e in evidence)
    before, after, rest_of_test = _errors(ex.old, ex.better, ex.test)
    progress('telling where the residual lives')
    structure = structures(model, ex.better, ex.residual, ex.evidence, ex.warmed[0])
    findings, doubts = _found(model, ex, names, (before, after), structure)
    findings, moved, instead = moved_zero(findings, model, ex.trace)
    findings, between, state = _beyond_recordings(findings, model, ex)
    cannot = [*state, *by_name, *told, *ex.unused, *ex.warmed[1], *slow_joint_states(ex.evidence),
              *noisier_recordings(ex.residual, ex.evidence),
              *ex.still.values(), *expected_changes(model, ex.better, ex.trace),
              *_unfinished(ex.trace),
              *repeated(ex.residual.cut, ex.evidence, ex.test),
              *odd_recordings(model, (*ex.evidence, *test),
                              lambda parts: _sliding(ex.better, parts),
                              lambda parts: find_residual(model, parts, cut=False).expected),
              *_nearly(model.robot, ex.trace, findings, _structured(rest_of_test))]
    findings += mostly_structure(model.robot, ex.residual, ex.rest, findings, structure,
                                 ex.trace.trials)
    findings, drifts = drifting(findings, model.robot.joints, structure)
    warm = within_unknown_temperature(model, ex.evidence, ex.residual, ex.rest)
    findings, why = without_unknown_temperature(findings, model.robot, warm, ex.residual, ex.rest)
    better = with_stated_shapes(ex.better, findings)
    correction = offered(better, findings, ex.evidence,
                         lambda m: (_errors(ex.old, m, ex.test)[1], _sliding(m, ex.test)))
    return with_correction(Diagnosis(
        model.robot.name, tuple(model.robot.joints), before, after, rest_of_test.noise, findings,
        rest_of_test.least_structure, (*cannot, *why), recordings=names, tested_on=tested_on,
        seen=() if ex.refitted else seen, refitted=ex.refitted, left_out=left_out,
        seconds=time.monotonic() - began,
        remains=doubts + instead + drifts + between
        + gains_in_doubt(findings, ex.trace.steps, model.robot.joints)
        + sentences_on(structure, model.robot.joints),
        structure=structure, sliding=_sliding(ex.better, ex.test), noise_most=rest_of_test.most,
        another_state=bool(state), moved_zero=moved,
        stated=np.hypot(model.residuals.rmse, np.where(
            warm, ex.residual.expected, 0.0))), correction), better


def _of_recordings(robot, evidence, test, ex):
    """Return sentences on what recordings are like, and how much of them says nothing."""
    return [*long_loads(evidence, ex.whole, ex.outside.found), *many_rejected(evidence),
            *clipped_efforts(robot, [*evidence, *test])]


def _found(model, ex, names, errors, structure):
    """
    Return Findings with the verdicts that hold, and sentences on why some do not.

    ex: Explanation of recordings with these names; errors: RMSE (n,) [Nm] of both models on the
    test; structure: (Structure before, Structure after).
    """
    better, trace, joints = ex.better, ex.trace, model.robot.joints
    left = unexplained_joints(ex.residual, ex.rest)
    odd = left + trace.unexplained()
    once, gone = findings_again(model.robot, names, ex.outside.shown, ex.seen, odd)
    findings = findings_of(model, better, trace, odd)
    soft = soft_end_doubts(findings, trace)
    findings += once + unknown_left(model, ex.residual, ex.rest, left, trace, structure)
    findings, doubts = refuted(findings, joints, *errors,
                               lambda k: _errors_without(model, ex, trace.steps[k]))
    findings, filters = without_filters(findings)
    findings, kinds = of_another_kind(findings, ex.residual.interval,
                                      faint_in(model, better, trace))
    findings, unsure = without_unsure(findings, unsure_in(model, better, trace))
    findings, wrong = on_wrong_footing(findings, joints, model, better)
    findings, small = small_beside_others(findings)
    findings, further = further_terms(findings, model, ex.residual)
    if ex.residual.cut.shown is not None:
        findings = only_suspected(findings)
    return findings, filters + wrong + kinds + unsure + small + further + doubts + gone + soft


def _errors_without(model, ex, step):
    """Return RMSE (n,) [Nm] on the test of a model without a Step, and of the better one."""
    other = better_model(model, [own for own in ex.steps if own is not step], ex.evidence)
    return _errors(other, ex.better, ex.test)[:2]


def _errors(model, better, test):
    """Return RMSE (n,) [Nm] of both models on test data while joints slide, Rest of the new."""
    old = errors_of(model, test)
    # Each model knows its friction state at other times; both are judged where the first does. A
    # better one that turns friction over a radian would be judged nowhere.
    new = np.concatenate([find_residual(better, [e], cut=False).residual for e in test])
    known = np.isfinite(old)
    # Nor at joints that a contact or the arm's own shaking moves for a moment.
    known[:, list(still_joints(better, test))] = False
    old, new = (np.where(known, e, np.nan) for e in (old, new))
    rest = rest_of(new, np.concatenate([e.motion.dt for e in test]),
                   np.concatenate([e.motion.messages for e in test]),
                   np.concatenate([np.full(len(e.motion.dt), k) for k, e in enumerate(test)]))
    return _rms(old), rest.rms, rest


def errors_of(model, evidence):
    """Return tau_real - tau_mdl (N, n) [Nm], NaN where a joint does not surely slide."""
    residuals = [find_residual(model, [e], cut=False) for e in evidence]
    return np.concatenate([np.where(r.moving, r.residual, np.nan) for r in residuals])


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


def _beyond_recordings(findings, model, ex):
    """Return Findings that recordings of these temperatures, and of this arm, can confirm; why."""
    findings, between = between_two_temperatures(findings, model.robot.joints, ex.evidence)
    findings, unfelt = not_felt(findings, model, ex.better, ex.warmed[0])
    findings, state = of_another_state(findings, model, ex.residual)
    return findings, between + unfelt, state


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
