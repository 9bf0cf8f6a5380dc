"""Fine-tuning starts from an artefact's weights, is calibrated anew and says whence it came."""

from dataclasses import replace
import hashlib
import json
import os

from core_helpers import exact_model
import numpy as np
import pytest
from safetensors.numpy import load_file
import torch

from hand_load_estimator import seeds
from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.learning import shards, training_loop
from hand_load_estimator.learning.artefact import (arm_of, CARD, read_artefact, WEIGHTS,
                                                   write_artefact)
from hand_load_estimator.learning.features import feature_count
from hand_load_estimator.learning.interval_factors import LEVELS
from hand_load_estimator.learning.network import LoadNetwork
from hand_load_estimator.learning.training import FINE_TUNING, Recipe, train
from hand_load_estimator.learning.training_loop import optimise
from hand_load_estimator.torque.model_file import write_model

HIDDEN = 8
# Batches of two sequences, so that a shard is a moment's work.
TINY = Recipe(sequences=4, calibration=2, validation=2, passes=3, learning_rate=1e-3, hidden=5)


class Killed(Exception):
    """Stands for a kill: nothing after it runs."""


@pytest.fixture(scope='module', autouse=True)
def small_batches():
    """Make shards of two sequences."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shards, 'BATCH', 2)
        patch.setattr(training_loop, 'CHECKPOINT_EVERY', 2)
        patch.setattr(os, 'cpu_count', lambda: 1)
        yield


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a model and an artefact of its arm, as a training might leave it."""
    out = tmp_path_factory.mktemp('fine_tuning')
    model = exact_model('four', doubt=0.02)
    write_model(out / 'model.yaml', model)
    network = LoadNetwork(feature_count(4), 4, HIDDEN)
    rng = np.random.default_rng(1)
    weights = {name: 0.1 * rng.normal(size=value.shape)
               for name, value in network.state_dict().items()}
    write_artefact(out / 'first', weights, np.full((10, len(LEVELS)), 7.0), {
        'name': 'the first', **arm_of(model.robot)})
    return out


def tuned(folder, name, recipe=TINY, write=lambda text: None):
    """Fine-tune `first` into a folder of that name and return its tensors."""
    train(folder / 'model.yaml', folder / name, recipe, 'cpu', write, folder / 'first')
    return load_file(folder / name / WEIGHTS)


@pytest.fixture(scope='module')
def recalibrated(folder):
    """Return the tensors after a fine-tuning without a pass."""
    said = []
    tensors = tuned(folder, 'recalibrated', Recipe(calibration=4, validation=2, passes=0),
                    said.append)
    return tensors, said


@pytest.fixture(scope='module')
def whole(folder):
    """Return the tensors of an undisturbed fine-tuning."""
    return tuned(folder, 'whole')


def test_without_a_pass_the_weights_stay_and_the_calibration_is_new(folder, recalibrated):
    first, (tensors, said) = load_file(folder / 'first' / WEIGHTS), recalibrated
    assert set(first) == set(tensors)
    for name in set(first) - {'calibration'}:
        np.testing.assert_array_equal(tensors[name], first[name], err_msg=name)
    assert (tensors['calibration'] != 7.0).all()
    assert not any('training' in line for line in said)


def test_the_first_weights_are_the_artefacts(folder, whole):
    """At this learning rate nothing gets far from where it began, and a new network is far."""
    first = load_file(folder / 'first' / WEIGHTS)
    moved = {name: np.abs(whole[name] - first[name]).max() for name in first}
    moved.pop('calibration')
    steps = TINY.passes * TINY.sequences // 2
    assert 0.0 < max(moved.values()) <= 1.5 * steps * TINY.learning_rate
    assert whole['lstm.weight_hh_l0'].shape == (4 * HIDDEN, HIDDEN), 'the size is the start\'s'


def test_a_killed_fine_tuning_goes_on_where_it_was(folder, whole):
    def kill(text):
        if text.startswith('training step 4/'):
            raise Killed
    with pytest.raises(Killed):
        tuned(folder, 'again', write=kill)
    said = []
    again = tuned(folder, 'again', write=said.append)
    assert [line.split('  ')[0] for line in said] == ['training step 6/6']
    for name, value in whole.items():
        np.testing.assert_allclose(again[name], value, rtol=1e-6, atol=1e-7, err_msg=name)


def test_a_kill_is_not_picked_up_with_another_start(folder):
    def kill(text):
        raise Killed
    with pytest.raises(Killed):
        tuned(folder, 'mixed', write=kill)
    with pytest.raises(ConfigurationError, match='another model, recipe or start'):
        train(folder / 'model.yaml', folder / 'mixed', TINY, 'cpu', print)
    with pytest.raises(ConfigurationError, match='another model, recipe or start'):
        train(folder / 'model.yaml', folder / 'mixed', TINY, 'cpu', print,
              folder / 'recalibrated')


def test_a_kill_is_picked_up_with_the_same_model_diagnosed_again(folder, tmp_path):
    """`diagnose --fine-tune` dates the model in every run; with another one it is refused."""
    model = exact_model('four', doubt=0.02)

    def fine_tune(model):
        write_model(tmp_path / 'model.yaml', model)

        def kill(text):
            raise Killed
        train(tmp_path / 'model.yaml', tmp_path, TINY, 'cpu', kill, folder / 'first')

    for seconds in (1, 2):
        with pytest.raises(Killed):
            fine_tune(replace(model, diagnosed=f'2026-03-01T14:30:0{seconds}+01:00'))
    for other in (replace(model, covariance=1.1 * model.covariance),
                  replace(model, mean=1.1 * model.mean)):
        with pytest.raises(ConfigurationError, match='another model'):
            fine_tune(other)


@pytest.mark.parametrize('steps', [9, 10, 11])
def test_any_number_of_steps_can_be_trained(tmp_path, monkeypatch, steps):
    """Ten, as of 64 sequences and ten passes, divided by the zero length of the warm-up."""
    monkeypatch.setattr(shards, 'read_shard', lambda path, device: 1.0)
    network = torch.nn.Linear(1, 1)
    before = network.bias.item()
    optimise(network, Recipe(passes=steps), ['one'],
             lambda network, shard, step: (network.bias - shard).square().sum(), tmp_path, print)
    assert 0.0 < abs(network.bias.item() - before) < steps * Recipe().learning_rate


def test_the_card_says_what_it_was_made_from(folder, whole):
    card = json.loads((folder / 'whole' / CARD).read_text())
    for key, path in (('started_from', folder / 'first' / WEIGHTS),
                      ('model', folder / 'model.yaml')):
        assert card[key]['sha256'] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert card['started_from']['name'] == 'the first'
    assert card['model']['file'] == 'model.yaml'
    assert card['recipe']['hidden'] == HIDDEN and card['recipe']['passes'] == TINY.passes
    assert card['seeds']['training'] == seeds.TRAINING.stop - TINY.sequences
    read_artefact(folder / 'whole', exact_model('four').robot)


@pytest.mark.parametrize('beside', [True, False])
def test_the_card_says_whether_there_were_temperatures(folder, tmp_path, beside):
    """Of what trained the weights: a fine-tuning without a pass is not asked."""
    content = json.loads((folder / 'first' / CARD).read_text())
    (tmp_path / CARD).write_text(json.dumps({**content, 'temperatures': beside}))
    (tmp_path / WEIGHTS).write_bytes((folder / 'first' / WEIGHTS).read_bytes())
    for passes, expected in ((0, beside), (1, True)):
        recipe = Recipe(sequences=2, calibration=4, validation=2, passes=passes)
        train(folder / 'model.yaml', tmp_path / 'out', recipe, 'cpu', lambda text: None, tmp_path)
        card = json.loads((tmp_path / 'out' / CARD).read_text())
        assert card['temperatures'] is expected


def test_without_start_and_pass_the_regression_alone_is_calibrated(folder, tmp_path):
    recipe = Recipe(sequences=2, calibration=4, validation=2, passes=0, hidden=HIDDEN)
    scores = train(folder / 'model.yaml', tmp_path, recipe, 'cpu', lambda text: None)
    assert scores['mass_rmse_kg_lstm'] == scores['mass_rmse_kg_without_network']
    artefact = read_artefact(tmp_path, exact_model('four').robot)
    assert not any(artefact.weights[f'{head}.{part}'].any() for head in ('joint_head', 'load_head')
                   for part in ('weight', 'bias'))
    assert np.unique(artefact.calibration).size > 1


def test_fine_tuning_sees_draws_that_training_did_not():
    assert Recipe().sequences + FINE_TUNING.sequences <= len(seeds.TRAINING)
    assert FINE_TUNING.sequences <= 0.25 * Recipe().sequences
    assert FINE_TUNING.learning_rate < Recipe().learning_rate


@pytest.mark.parametrize('change, word', [
    ({'joints': ['a', 'b', 'c', 'd']}, 'other joints'),
    ({'effort_kind': 'motor_current'}, 'another kind of effort')])
def test_another_arms_artefact_is_refused(folder, tmp_path, capsys, change, word):
    artefact = read_artefact(folder / 'first', exact_model('four').robot)
    write_artefact(tmp_path / 'other', artefact.weights, artefact.calibration,
                   {**artefact.card, **change})
    assert main(['train', '--model', str(folder / 'model.yaml'), '--start-from',
                 str(tmp_path / 'other'), '--out', str(tmp_path / 'out')]) == 2
    said = capsys.readouterr().err.strip()
    assert word in said and '\n' not in said
    assert not (tmp_path / 'out').exists()


def test_a_network_of_another_kind_is_refused(folder, tmp_path):
    artefact = read_artefact(folder / 'first', exact_model('four').robot)
    weights = {**artefact.weights, 'joint_head.weight': np.zeros((1, HIDDEN + 1))}
    write_artefact(tmp_path, weights, artefact.calibration, artefact.card)
    with pytest.raises(ConfigurationError, match='joint_head.weight'):
        train(folder / 'model.yaml', tmp_path / 'out', TINY, 'cpu', print, tmp_path)


@pytest.mark.parametrize('arguments, word', [
    (['--start-from', 'nowhere'], 'nowhere'),
    (['--start-from', 'first', '--network', 'gru'], '--start-from'),
    (['--start-from', 'first', '--passes', '-1'], '--passes'), (['--passes', '-1'], '--passes'),
    (['--network', 'gru', '--passes', '0'], '--passes')])
def test_wrong_arguments_end_with_two(folder, tmp_path, capsys, monkeypatch, arguments, word):
    monkeypatch.chdir(folder)
    assert main(['train', '--model', 'model.yaml', '--out', str(tmp_path / 'out'),
                 *arguments]) == 2
    said = capsys.readouterr().err.strip()
    assert word in said and '\n' not in said
