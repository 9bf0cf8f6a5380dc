"""A diagnosis as plain JSON content: schema hand_load/diagnosis/1 (DESIGN.md section 4)."""

import math

from ..residual.doubts.not_named import not_named

SCHEMA = 'hand_load/diagnosis/1'


def _number(value):
    """Return a float, or None where the value is missing, NaN or infinite."""
    return float(value) if value is not None and math.isfinite(value) else None


def _numbers(values):
    return [_number(value) for value in values]


def _parameters(parameters):
    return {name: {'mean': _number(mean), 'std': _number(std), 'unit': unit}
            for name, (mean, std, unit) in parameters.items()}


def _evidence(evidence):
    return {'gain': _number(evidence.gain), 'gain_std': _number(evidence.gain_std),
            'needed': _number(evidence.needed), 'blocks': int(evidence.blocks),
            'hypotheses': int(evidence.hypotheses), 'rms': _number(evidence.rms),
            'next_best': evidence.next_best, 'margin': _number(evidence.margin),
            'next_best_possible': None if evidence.next_best is None else evidence.next_possible,
            'by_joint': {j: _number(gain) for j, gain in evidence.by_joint.items()}}


def alternatives_content(finding):
    """Return what is told of a Finding's alternatives, in their order; behind, std [nats]."""
    return [{'effect': other.name, 'joints': list(other.joints), 'behind': _number(other.behind),
             'std': _number(other.std)} for other in finding.alternatives]


def _effect(finding):
    return {'name': finding.name, 'joints': list(finding.joints),
            'parameters': _parameters(finding.parameters),
            'explained': _numbers(finding.explained),
            'evidence': _evidence(finding.evidence),
            'alternatives': list(dict.fromkeys(other.name for other in finding.alternatives)),
            'alternatives_detail': alternatives_content(finding),
            'verdict': finding.verdict,
            'advice': finding.advice, 'changed': bool(finding.changed),
            'variables': list(finding.variables), 'recording': finding.recording or None}


def _one_load_error(error):
    return {'mass_rmse': _number(error.mass_rmse), 'com_rmse': _number(error.com_rmse),
            'n': int(error.n)}


def _load_error(diagnosis):
    """Return the keys about load estimates: an error needs both sides to mean something."""
    both = _both_load_errors(diagnosis)
    return {'load_error': both} if both else {'load_error': None,
                                              'load_error_reason': diagnosis.load_reason}


def _both_load_errors(of):
    if of.load_before is None or of.load_after is None:
        return None
    return {'before': _one_load_error(of.load_before), 'after': _one_load_error(of.load_after)}


def _part(share):
    """Return a share cut to [0, 1], None where it is not known."""
    return _number(min(max(share, 0.0), 1.0))


def _parts(shares):
    return {name: [_part(value) for value in values] for name, values in shares.items()}


def _side(structure):
    return {'torque_rmse': _numbers(structure.rms),
            'structured': [_part(share) for share in structure.structured],
            'share': _parts(structure.share), 'chance': _parts(structure.chance),
            'pairs': [[_part(share) for share in row] for row in structure.pairs],
            'pairs_chance': [[_part(share) for share in row] for row in structure.pairs_chance]}


def _structure(structure):
    if structure is None:
        return None
    before, after = structure
    return {'variables': list(before.share), 'noise': _numbers(before.noise),
            'before': _side(before), 'after': _side(after)}


def _not_named(diagnosis):
    """Return for each joint what structure without a name follows, with its share of it."""
    if diagnosis.structure is None:
        return None
    return [[{'follows': what, 'share': share} for what, share in found]
            for found in not_named(diagnosis.structure, diagnosis.joints)]


def _learned(fine_tuning, kept, training):
    if training:
        return {'done': 'not finished'}
    if kept is not None:
        return {'done': 'kept', 'artefact': kept.name, **_with_network(kept)}
    if fine_tuning is None:
        return {'done': 'kept'}
    return {'done': 'fine-tuned', 'started_from': fine_tuning.started_from, 'folder': 'learned',
            **_with_network(fine_tuning)}


def _with_network(of):
    after = of.load_after
    return {'load_error': _both_load_errors(of),
            'not_asked': None if after is None else int(after.not_asked)}


def diagnosis_content(diagnosis):
    """
    Return a Diagnosis as a dict of plain JSON values.

    Torques [Nm], mass_rmse [kg], com_rmse [m], gains [nats], lists per joint in the order of
    `joints`; a number that is not known is None. `load_error_reason` is there when `load_error`
    is None.
    """
    return {
        'schema': SCHEMA, 'robot': diagnosis.robot, 'joints': list(diagnosis.joints),
        'before': {'torque_rmse': _numbers(diagnosis.before)},
        'after': {'torque_rmse': _numbers(diagnosis.after)},
        'noise_floor': _numbers(diagnosis.noise_floor),
        'stated': None if diagnosis.stated is None else _numbers(diagnosis.stated),
        'noise_most': None if diagnosis.noise_most is None else _numbers(diagnosis.noise_most),
        'effects': [_effect(finding) for finding in diagnosis.findings],
        'unexplained': _numbers(diagnosis.unexplained),
        'unexplained_most': _numbers(diagnosis.unexplained_most), **_load_error(diagnosis),
        'another_state': diagnosis.another_state, 'moved_zero': diagnosis.moved_zero,
        'cannot_tell': list(diagnosis.cannot_tell), 'remains': list(diagnosis.remains),
        'recordings': list(diagnosis.recordings), 'tested_on': diagnosis.tested_on,
        'test_seen_by_model': list(diagnosis.seen), 'refitted': diagnosis.refitted,
        'test_left_out_seconds': _number(diagnosis.left_out),
        'correction': None if diagnosis.correction is None else {
            'model': 'model_with_correction.yaml',
            'torque_rmse': _numbers(diagnosis.correction.after)},
        'not_named': _not_named(diagnosis),
        'structure': _structure(diagnosis.structure),
        'learned': _learned(diagnosis.fine_tuning, diagnosis.kept, diagnosis.training),
        'seconds': _number(diagnosis.seconds)}
