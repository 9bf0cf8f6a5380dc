"""The LSTM's artefact as files: what they are, how they are named, and what is refused."""

import json

from core_helpers import exact_model, four_axes
from lstm_helpers import artefact_of, network_of
import numpy as np
import pytest

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_method
from hand_load_estimator.learning.artefact import read_artefact
from hand_load_estimator.torque.model_follower import ModelFollower


@pytest.fixture(scope='module')
def robot():
    return four_axes()


def test_the_artefact_is_two_small_files_without_pickle(tmp_path, robot):
    artefact_of(tmp_path, robot, network_of(robot))
    assert sorted(p.name for p in tmp_path.iterdir()) == ['card.json', 'lstm.safetensors']
    assert json.loads((tmp_path / 'card.json').read_text())['schema'] == 'hand_load/learned/1'


def wreck(folder, how):
    """Damage an artefact in a named way."""
    weights, card = folder / 'lstm.safetensors', folder / 'card.json'
    content = json.loads(card.read_text())
    changes = {'joints': ['a', 'b', 'c', 'd'], 'effort_kind': 'motor_current',
               'schema': 'hand_load/learned/9', 'places': None, 'inputs': ['q', 'v']}
    if how in changes:
        card.write_text(json.dumps({**content, how: changes[how]}))
    elif how == 'card is a list':
        card.write_text('[]')
    elif how == 'joints are a number':
        card.write_text(json.dumps({**content, 'joints': 4}))
    elif how == 'card is no JSON':
        card.write_text('{')
    elif how == 'no card':
        card.unlink()
    elif how == 'no weights':
        weights.unlink()
    elif how == 'weights cut':
        weights.write_bytes(weights.read_bytes()[:-50])
    elif how == 'weights are noise':
        weights.write_bytes(b'\xff' * 500)
    else:
        tensors = _read(weights)
        if how == 'a tensor missing':
            del tensors['load_head.bias']
        elif how == 'a tensor of another shape':
            tensors['load_head.bias'] = tensors['load_head.bias'][:-1]
        elif how == 'a tensor of another rank':
            tensors['lstm.weight_hh_l0'] = tensors['lstm.weight_hh_l0'].ravel()
        elif how == 'a NaN':
            tensors['load_head.bias'][0] = np.nan
        elif how == 'a calibration of nothing':
            tensors['calibration'][0] = 0.0
        _write(weights, tensors)


def _read(path):
    from safetensors.numpy import load_file
    return {k: v.copy() for k, v in load_file(path).items()}


def _write(path, tensors):
    from safetensors.numpy import save_file
    save_file(tensors, path)


@pytest.mark.parametrize('how', [
    'joints', 'effort_kind', 'schema', 'places', 'inputs', 'card is a list',
    'joints are a number', 'card is no JSON', 'no card', 'no weights', 'weights cut',
    'weights are noise',
    'a tensor missing', 'a tensor of another shape', 'a tensor of another rank', 'a NaN',
    'a calibration of nothing'])
def test_what_does_not_belong_or_is_damaged_is_refused(tmp_path, robot, how):
    artefact_of(tmp_path, robot, network_of(robot))
    wreck(tmp_path, how)
    with pytest.raises(ConfigurationError) as caught:
        read_artefact(tmp_path, robot)
    assert str(tmp_path) in str(caught.value)


def test_build_takes_the_named_artefact(tmp_path, robot):
    artefact_of(tmp_path, robot, network_of(robot))
    model = exact_model('four')
    method = build_method(model, ModelFollower(model).uncertainties, 'lstm', str(tmp_path))
    assert method.name == 'lstm'
