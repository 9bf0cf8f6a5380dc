"""Direct networks as methods: in a pipeline, found by their card, refused where damaged."""

import json

from core_helpers import block, exact_model, feed, four_axes, messages, pipeline_of, warm
from direct_helpers import artefact_of, design_of, network_of, pipeline_with
import numpy as np
import pytest
from safetensors.numpy import load_file, save_file
import torch

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_method, shipped_artefact
from hand_load_estimator.estimators.contact_gate import ContactGate
from hand_load_estimator.learning.direct_artefact import read_direct_artefact
from hand_load_estimator.learning.direct_network import inputs_of, Judge
from hand_load_estimator.torque.model_follower import ModelFollower


@pytest.fixture(scope='module')
def robot():
    return four_axes()


@pytest.fixture(scope='module')
def artefact(tmp_path_factory, robot):
    return artefact_of(tmp_path_factory.mktemp('gru'), robot, network_of(robot, design_of(robot)))


def test_the_method_answers_what_the_network_answers_in_training(robot, artefact):
    model = exact_model('four')
    pipeline, seen = pipeline_with(model, artefact), []
    update = pipeline.method.update

    def spied(sample, prediction):
        seen.append((sample, prediction))
        return update(sample, prediction)

    pipeline.method.update = spied
    feed(pipeline, messages(model, block(2.0), 3.0))
    last = pipeline.method.belief()
    parts = [np.array([getattr(s, name) for s, _ in seen]) for name in ('q', 'v', 'a')]
    parts += [np.array([p.difference for _, p in seen]),
              np.array([s.temperature for s, _ in seen]) - robot.reference_temperature]
    q, v, a, difference, warmth = torch.tensor(np.array(parts), dtype=torch.float32)[:, None]
    mean, std, _ = Judge(robot, artefact.network)(inputs_of(
        robot, [0, 1, 2, 3], (q, v, a), difference, warmth))
    np.testing.assert_allclose(last.mean, mean[0, -1], rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(np.sqrt(np.diag(last.covariance)), std[0, -1], rtol=1e-4)


def test_a_changed_load_restarts_the_network_in_step_with_bayes(artefact):
    model = exact_model('four')
    stream = messages(model, block(0.5), 3.5, change=(1.8, block(3.0)))
    bayes, ours = warm(pipeline_of(model)), pipeline_with(model, artefact)
    plain, said = feed(bayes, stream), feed(ours, stream)
    assert [e.load_id for e in said] == [e.load_id for e in plain] and ours.load_id > 0


def test_samples_of_a_contact_do_not_reach_the_network(artefact, monkeypatch):
    model = exact_model('four')
    stream = messages(model, block(2.0), 2.4)
    pipeline = pipeline_with(model, artefact)
    before = feed(pipeline, stream[:len(stream) // 2])[-1]
    for name in ('update', 'refuses'):
        monkeypatch.setattr(ContactGate, name, lambda *_: True)
    after = feed(pipeline, stream[len(stream) // 2:])[-1]
    np.testing.assert_array_equal(after.mean, before.mean)
    monkeypatch.undo()
    free = feed(pipeline_with(model, artefact), stream)[-1]
    assert np.abs(free.mean - before.mean).max() > 1e-4


def test_reset_returns_to_the_prior_and_tare_takes_the_load_off(artefact):
    model = exact_model('four')
    stream = messages(model, block(2.0), 1.8)
    pipeline = pipeline_with(model, artefact)
    fresh = pipeline.estimate(0.0)
    feed(pipeline, stream)
    held = pipeline.method.belief()
    pipeline.reset()
    np.testing.assert_array_equal(pipeline.estimate(0.0).mean, fresh.mean)
    feed(pipeline, stream)
    pipeline.method.tare()
    assert pipeline.tared_mass == pytest.approx(2.0, abs=0.15)
    later = [type(m)(m.stamp + 3.5, *list(vars(m).values())[1:]) for m in stream]
    feed(pipeline, later)
    bare = pipeline_with(model, artefact)
    feed(bare, messages(model, block(1e-6), 1.8))
    # What is published is made possible, but not after tare: compare what is believed.
    tared, empty = pipeline.method.belief(), bare.method.belief()
    np.testing.assert_allclose(tared.mean, empty.mean, atol=0.1 * np.abs(held.mean - empty.mean)
                               .max())
    assert tared.covariance[0, 0] > empty.covariance[0, 0]


def test_the_card_decides_which_artefact_is_found(tmp_path, robot, artefact, monkeypatch):
    from hand_load_estimator.estimators import build
    monkeypatch.setattr(build, 'share_folder', lambda: tmp_path)
    for name in ('elman', 'gru'):
        folder = tmp_path / 'config' / 'learned' / f'four_{name}'
        artefact_of(folder, robot, network_of(robot, design_of(robot, name)))
        assert shipped_artefact(robot, name) == folder
    assert shipped_artefact(robot) is None and shipped_artefact(robot, 'feedforward') is None
    model = exact_model('four')
    for name, becomes in (('elman', 'elman'), ('feedforward', 'bayes'), ('lstm', 'bayes')):
        assert build_method(model, ModelFollower(model).uncertainties, name).name == becomes


@pytest.mark.parametrize('how', ['network', 'joints', 'design', 'copies', 'learns', 'a NaN',
                                 'a tensor missing',
                                 'factors of nothing', 'joints of another robot'])
def test_what_does_not_belong_or_is_damaged_is_refused(tmp_path, robot, how):
    artefact_of(tmp_path, robot, network_of(robot, design_of(robot)))
    card = json.loads((tmp_path / 'card.json').read_text())
    weights = tmp_path / 'network.safetensors'
    tensors = {k: v.copy() for k, v in load_file(weights).items()}
    if how == 'network':
        card['network'] = 'elman'
    elif how == 'joints':
        card['joints'] = ['a', 'b', 'c', 'd']
    elif how == 'learns':
        del card['learns']   # As of networks that answered the centre itself.
    elif how == 'design':
        del card['recipe']['design']['hidden'], card['recipe']['design']['network']
    elif how == 'copies':
        card['recipe']['design']['copies'] = '16'
    elif how == 'joints of another robot':
        card['recipe']['design']['joints'] = ['a', 'j1', 'j2', 'j3']
    elif how == 'a tensor missing':
        del tensors['network.head.bias']
    elif how == 'a NaN':
        tensors['network.head.bias'][0] = np.nan
    else:
        tensors['factors'][:] = 0.0
    (tmp_path / 'card.json').write_text(json.dumps(card))
    save_file(tensors, weights)
    with pytest.raises(ConfigurationError) as caught:
        read_direct_artefact(tmp_path, robot, 'gru')
    assert str(tmp_path) in str(caught.value)
