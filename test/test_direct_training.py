"""`hand_load train --network`: E1.3 to E1.6 as artefacts, handed over as a folder (E10.1)."""

from dataclasses import replace
import json

from core_helpers import block, exact_model, feed, messages, warm
import numpy as np
import pytest
from safetensors.numpy import load_file
import torch

from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.learning import direct_training, shards, training, training_loop
from hand_load_estimator.learning.direct_design import Design, design_for
from hand_load_estimator.learning.direct_training import DirectRecipe, train_direct
from hand_load_estimator.learning.objective import DIVERGENCES
from hand_load_estimator.torque.model_file import write_model

STEPS = 4


class Killed(Exception):
    """The end of a training in mid course."""


def recipe_for(robot, network='two_network'):
    """Return a DirectRecipe of a second's work."""
    design = design_for(robot, network, parameters=('m', 'x', 'y', 'z'))
    return DirectRecipe(Design(**{**vars(design), 'hidden': 8}), 8, 8, 8, passes=STEPS)


@pytest.fixture(scope='module')
def trained(tmp_path_factory):
    """Return folder with a model, a training undisturbed and one that was broken off."""
    out = tmp_path_factory.mktemp('direct')
    model = exact_model('four', doubt=0.02)
    write_model(out / 'model.yaml', model)
    said = []

    def write(text):
        said.append(text)
        if breaks and text.startswith('training step 2/'):
            raise Killed

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shards, 'BATCH', 8)
        patch.setattr(training_loop, 'CHECKPOINT_EVERY', 1)
        breaks = True
        with pytest.raises(Killed):
            train_direct(out / 'model.yaml', out / 'again', recipe_for(model.robot), 'cpu', write)
        breaks = False
        for name in ('again', 'whole'):
            said.append(name)
            train_direct(out / 'model.yaml', out / name, recipe_for(model.robot), 'cpu', write)
    return out, said


def test_a_training_broken_off_goes_on_and_ends_as_an_undisturbed_one(trained):
    out, said = trained
    resumed = said[said.index('again') + 1:said.index('whole')]
    assert resumed[0].startswith(f'training step 3/{STEPS}')
    whole, again = (load_file(out / name / 'network.safetensors') for name in ('whole', 'again'))
    assert set(whole) == set(again) > {'knots', 'factors'}
    for name, value in whole.items():
        np.testing.assert_allclose(again[name], value, rtol=1e-5, atol=1e-6, err_msg=name)


def test_E10_1_the_folder_is_all_that_is_handed_over(trained):
    folder = trained[0] / 'whole'
    assert sorted(p.name for p in folder.rglob('*')) == ['card.json', 'network.safetensors']
    card = json.loads((folder / 'card.json').read_text())
    assert card['network'] == 'two_network' and card['recipe']['sequences'] == 8
    assert card['recipe']['design']['parameters'] == ['m', 'x', 'y', 'z']
    assert set(card['held_out']['coverage_of_95']) == {'m', 'x', 'y', 'z'}
    pipeline = warm(build_pipeline(trained[0] / 'model.yaml', 'two_network', str(folder)))
    last = feed(pipeline, messages(exact_model('four'), block(2.0), 1.0))[-1]
    assert np.isfinite(last.mean).all() and pipeline.method.name == 'two_network'


def test_E6_1_another_divergence_trains_another_network_and_the_card_says_which(
        trained, tmp_path, monkeypatch):
    monkeypatch.setattr(shards, 'BATCH', 8)
    robot = exact_model('four').robot
    train_direct(trained[0] / 'model.yaml', tmp_path,
                 replace(recipe_for(robot), divergence='jensen_shannon'), 'cpu', print)
    kinds = [json.loads((folder / 'card.json').read_text())['recipe']['divergence']
             for folder in (trained[0] / 'whole', tmp_path)]
    assert kinds == ['kl', 'jensen_shannon']
    one, other = (load_file(folder / 'network.safetensors')['network.load.head.bias']
                  for folder in (trained[0] / 'whole', tmp_path))
    assert np.isfinite(other).all() and np.abs(one - other).max() > 1e-4
    pipeline = warm(build_pipeline(trained[0] / 'model.yaml', 'two_network', str(tmp_path)))
    last = feed(pipeline, messages(exact_model('four'), block(2.0), 1.0))[-1]
    assert np.isfinite(last.mean).all() and (last.std > 0.0).all()


@pytest.mark.parametrize('network, module', [('lstm', training), ('gru', direct_training)])
@pytest.mark.parametrize('kind', [None, *DIVERGENCES])
def test_E6_1_the_divergence_is_chosen_by_name(trained, tmp_path, monkeypatch, network, module,
                                               kind):
    recipes = []
    monkeypatch.setattr(module, 'train' if network == 'lstm' else 'train_direct',
                        lambda model, folder, recipe, *_: recipes.append(recipe) or {})
    chosen = ['--divergence', kind] if kind else []
    assert main(['train', '--model', str(trained[0] / 'model.yaml'), '--network', network,
                 '--out', str(tmp_path / 'out'), *chosen]) == 0
    assert recipes[0].divergence == (kind or 'kl')


def test_an_artefact_goes_with_its_own_method_only(trained):
    for method in ('gru', 'lstm'):
        with pytest.raises(ConfigurationError, match='whole'):
            build_pipeline(trained[0] / 'model.yaml', method, str(trained[0] / 'whole'))


def test_pieces_grow_and_begin_anywhere(trained):
    """A change of load restarts the network in mid motion."""
    robot = exact_model('four').robot
    loss = direct_training.Loss(robot, recipe_for(robot), 25)
    time = torch.arange(500.0)[None, :, None] * torch.ones(3, 8, 1, 4)
    shard = {'motion': time, **{name: torch.zeros(8, 500, 4)
                                for name in ('warmth', 'columns', 'error')}}
    lengths = {}
    for step in range(100):
        motion = loss.pieces(np.random.default_rng(step), shard, step)['motion']
        assert (motion.diff(dim=2) == 1.0).all() and motion[0, :, :, 0].numel() > 4000
        lengths.setdefault(motion.shape[2], []).append(motion[0, :, 0, 0].numpy())
    assert list(lengths) == [10, 50, 200, 500] and len(lengths[10]) == 40
    from_start = np.mean(np.concatenate(lengths[200]) == 0.0)
    assert 0.35 < from_start < 0.65 and np.concatenate(lengths[200]).max() > 250
    assert np.mean(np.concatenate(lengths[10]) == 0.0) < 0.02


@pytest.mark.parametrize('arguments, said', [
    (['--network', 'gru', '--parameters', 'mass'], 'm, x, y, z'),
    (['--network', 'gru', '--joints', 'j0,j9'], 'j9'),
    (['--network', 'magic'], 'lstm_direct'),
    (['--network', 'gru', '--layers', '0'], '1 to 8'),
    (['--network', 'gru', '--divergence', 'hellinger'], 'jensen_shannon'),
    (['--network', 'dropout', '--divergence', 'kl'], 'does not go with --network dropout'),
    (['--network', 'gru', '--window', '10'], 'does not go with --network gru'),
    (['--layers', '2'], 'does not go with --network lstm'),
    (['--parameters', 'm'], 'does not go with --network lstm')])
def test_wrong_choices_end_with_two_and_a_line(trained, tmp_path, capsys, arguments, said):
    known = ['--model', str(trained[0] / 'model.yaml'), '--out', str(tmp_path / 'out')]
    try:
        status = main(['train', *known, *arguments])
    except SystemExit as ended:
        status = ended.code
    assert status == 2 and said in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()
