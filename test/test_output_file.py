"""A result that cannot be written is found out before the work, with what to do."""

import pytest

from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.output_file import output_file


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
