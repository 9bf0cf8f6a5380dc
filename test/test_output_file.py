"""A result that cannot be written is found out before the work, with what to do."""

import json

import pytest

from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.output_file import output_file, output_folder
from hand_load_estimator.learning.artefact import artefact_folder, CARD, SCHEMA


def test_a_place_that_is_there_is_taken(tmp_path):
    assert output_file(tmp_path / 'new.json') == tmp_path / 'new.json'


@pytest.mark.parametrize('name, said', [('nowhere/new.json', 'make the folder first'),
                                        ('.', 'is a folder')])
def test_a_place_that_is_none_is_told(tmp_path, name, said):
    with pytest.raises(ConfigurationError, match=said):
        output_file(tmp_path / name)


@pytest.mark.parametrize('command', [
    ['estimate', 'no_recording', '--model', 'ur10e', '--out'],
    ['identify', 'no_recording', '--robot', 'ur10e', '--out'],
    ['new-robot', 'no.urdf', '--out'], ['excite', '--robot', 'ur10e', '--out']])
def test_commands_look_before_they_read_anything(tmp_path, capsys, command):
    assert main([*command, str(tmp_path / 'nowhere' / 'result')]) == 2
    assert 'make the folder first' in capsys.readouterr().err


@pytest.mark.parametrize('there, kind', [
    ('schema: hand_load/torque_model/1', 'hand_load/torque_model/2'), ('', 'hand_load/estimate/1'),
    ('', None)])
def test_an_earlier_result_may_be_replaced(tmp_path, there, kind):
    (tmp_path / 'there').write_text(there)
    assert output_file(tmp_path / 'there', kind) == tmp_path / 'there'


@pytest.mark.parametrize('kind, said', [('hand_load/estimate/1', 'no earlier result'),
                                        (None, 'exists already')])
def test_a_file_of_another_kind_stays(tmp_path, kind, said):
    (tmp_path / 'load.yaml').write_text('mass: 2.0')
    with pytest.raises(ConfigurationError, match=said):
        output_file(tmp_path / 'load.yaml', kind)


def test_an_input_stays_by_whatever_name(tmp_path):
    model = tmp_path / 'model.yaml'
    model.write_text('schema: hand_load/torque_model/1')
    (tmp_path / 'link.yaml').symlink_to(model)
    with pytest.raises(ConfigurationError, match='what the command reads'):
        output_file(tmp_path / 'link.yaml', 'hand_load/torque_model/1', (None, 'none', model))


@pytest.mark.parametrize('command', [
    ['identify', 'no_recording', '--robot', 'ur10e', '--out'],
    ['estimate', 'no_recording', '--model', 'ur10e', '--out'],
    ['excite', '--robot', 'ur10e', '--out'], ['new-robot', 'no.urdf', '--out']])
def test_commands_leave_a_file_of_the_user(tmp_path, capsys, command):
    mine = tmp_path / 'mine.yaml'
    mine.write_text('name: my_arm')
    assert main([*command, str(mine)]) == 2
    assert str(mine) in capsys.readouterr().err and mine.read_text() == 'name: my_arm'


def test_a_model_is_not_drawn_over(tmp_path, capsys):
    pytest.importorskip('rclpy')
    mine = tmp_path / 'model.yaml'
    mine.write_text('name: my_arm')
    assert main(['demo', '--out', str(mine)]) == 2
    assert 'no earlier result' in capsys.readouterr().err


@pytest.mark.parametrize('name', ['.', 'new', 'new/below'])
def test_a_folder_is_there_or_can_be_made(tmp_path, name):
    assert output_folder(tmp_path / name) == tmp_path / name
    assert not list(tmp_path.iterdir()), 'it is made when there is something to write'


@pytest.mark.parametrize('command', [
    ['diagnose', 'no_recording', '--model', 'ur10e'], ['train', '--model', 'ur10e'],
    ['learn-gp', 'no_recording', '--model', 'ur10e'], ['simulate', '--robot', 'ur10e'],
    ['benchmark', '--workers', '1']])
@pytest.mark.parametrize('below', ['', 'below'])
def test_commands_look_for_their_folder_before_the_work(tmp_path, capsys, command, below):
    (tmp_path / 'file').write_text('')
    assert main([*command, '--out', str(tmp_path / 'file' / below)]) == 2
    said = capsys.readouterr().err.strip()
    assert f'{tmp_path / "file"} is no folder' in said and '\n' not in said


def test_an_artefact_is_not_fine_tuned_over_itself(tmp_path, capsys):
    assert main(['train', '--model', 'ur10e', '--start-from', str(tmp_path), '--out',
                 str(tmp_path)]) == 2
    assert 'what the command reads' in capsys.readouterr().err


@pytest.mark.parametrize('command, name', [
    (['train', '--model', 'ur10e'], 'card.json'),
    (['learn-gp', 'no_recording', '--model', 'ur10e'], 'difference.json'),
    (['benchmark'], 'README.md'), (['benchmark'], 'scores.json')])
def test_a_file_in_the_folder_stays_too(tmp_path, capsys, command, name):
    (tmp_path / name).write_text('mine')
    assert main([*command, '--out', str(tmp_path)]) == 2
    assert str(tmp_path / name) in capsys.readouterr().err


@pytest.mark.parametrize('there, command', [
    ('lstm', ['calibrate', '--method', 'bayes']), ('lstm', ['train', '--network', 'gru']),
    ('gru', ['train']), ('intervals of bayes', ['calibrate', '--method', 'least_squares'])])
def test_an_artefact_of_another_network_stays(tmp_path, capsys, there, command):
    """Its card was replaced, and its weights were nobody's."""
    (tmp_path / CARD).write_text(json.dumps({'schema': SCHEMA, 'network': there}))
    assert main([*command, '--model', 'ur10e', '--out', str(tmp_path)]) == 2
    assert 'another command or network' in capsys.readouterr().err


def test_an_artefact_of_the_same_network_may_be_replaced(tmp_path):
    for network in ('lstm', 'gru', 'intervals of bayes'):
        (tmp_path / CARD).write_text(json.dumps({'schema': SCHEMA, 'network': network}))
        assert artefact_folder(tmp_path, network) == tmp_path
    (tmp_path / CARD).write_text(f'no JSON, but {SCHEMA}')
    with pytest.raises(ConfigurationError, match='give another --out'):
        artefact_folder(tmp_path, 'lstm')
