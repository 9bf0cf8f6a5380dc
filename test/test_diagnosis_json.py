"""The report of a diagnosis as JSON: by the contract, strict, and it tells what is not known."""

import dataclasses
import json

from diagnosis_report_helpers import found, JOINTS, tuned
import pytest

from hand_load_estimator.report import diagnosis_json
from hand_load_estimator.residual.diagnosis import LoadError


def test_json_has_the_keys_of_the_contract():
    content = diagnosis_json.diagnosis_content(found())
    assert content['schema'] == 'hand_load/diagnosis/1'
    assert content['joints'] == list(JOINTS)
    assert content['before']['torque_rmse'][2] == 2.41
    assert content['after']['torque_rmse'][2] == 1.33
    assert content['noise_floor'][0] == 1.2
    effect = content['effects'][0]
    assert effect['parameters']['amplitude'] == {'mean': 2.71, 'std': 0.031, 'unit': 'Nm'}
    assert effect['explained'] == [0.0, 0.0, 0.71, 0.0, 0.0, 0.0]
    assert effect['evidence']['next_best'] == 'cable_drag'
    assert effect['evidence']['next_best_possible'] is True
    assert effect['verdict'] == 'confirmed'
    assert content['effects'][1]['alternatives'] == ['link_inertia', 'cable_drag']
    assert content['effects'][1]['alternatives_detail'] == [
        {'effect': 'link_inertia', 'joints': ['shoulder_lift_joint', 'wrist_1_joint'],
         'behind': 2.5, 'std': 4.0},
        {'effect': 'cable_drag', 'joints': ['shoulder_lift_joint'], 'behind': 12.5, 'std': 9.0}]
    assert content['load_error'] == {
        'before': {'mass_rmse': 0.412, 'com_rmse': 0.0141, 'n': 12},
        'after': {'mass_rmse': 0.122, 'com_rmse': 0.0062, 'n': 12}}
    assert 'load_error_reason' not in content


def test_json_is_strict_and_tells_what_is_not_known():
    content = diagnosis_json.diagnosis_content(found())
    assert content['unexplained'][5] is None
    assert content['effects'][2]['evidence']['margin'] is None
    assert json.loads(json.dumps(content, allow_nan=False)) == content


def test_json_says_what_became_of_the_artefact():
    assert diagnosis_json.diagnosis_content(found())['learned'] == {'done': 'kept'}
    assert diagnosis_json.diagnosis_content(tuned())['learned'] == {
        'done': 'fine-tuned', 'started_from': 'the <first>', 'folder': 'learned',
        'load_error': {'before': {'mass_rmse': 0.098, 'com_rmse': 0.0051, 'n': 12},
                       'after': {'mass_rmse': 0.087, 'com_rmse': 0.0048, 'n': 12}},
        'not_asked': 0}
    unloaded = diagnosis_json.diagnosis_content(tuned(None, None))['learned']
    assert unloaded['done'] == 'fine-tuned' and unloaded['load_error'] is None
    assert unloaded['not_asked'] is None
    silent = diagnosis_json.diagnosis_content(tuned(after=LoadError(0.09, 0.005, 12, 5)))
    assert silent['learned']['not_asked'] == 5


@pytest.mark.parametrize('missing', ['load_before', 'load_after'])
def test_json_has_a_load_error_with_both_sides_only(missing):
    half = dataclasses.replace(found(), **{missing: None}, load_reason='no known loads')
    content = diagnosis_json.diagnosis_content(half)
    assert content['load_error'] is None
    assert content['load_error_reason'] == 'no known loads'
