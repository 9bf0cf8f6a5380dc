"""`hand_load`: lists what is there, refuses in one line, imports only what it runs."""

import subprocess
import sys
from types import SimpleNamespace

from hand_load_estimator import __version__, cli
from hand_load_estimator.errors import ConfigurationError, RecordingError
import pytest


def refused(capsys, *argv):
    with pytest.raises(SystemExit) as exit_:
        cli.main(list(argv))
    assert exit_.value.code == 2
    return one_line(capsys)


def one_line(capsys):
    text = capsys.readouterr().err
    assert text.count('\n') == 1 and text.endswith('\n')
    return text


def fake_command(monkeypatch, run):
    module = SimpleNamespace(EXAMPLE='hand_load check x', run=run,
                             add_arguments=lambda parser: parser.add_argument('--n', type=int))
    monkeypatch.setattr(cli, 'import_module', lambda name: module)


def test_a_command_without_its_module_is_not_listed(monkeypatch, capsys):
    monkeypatch.setitem(cli.COMMANDS, 'fly', 'not written yet')
    assert 'fly' not in cli.available_commands()
    assert {'check', 'excite', 'new-robot'} <= set(cli.available_commands())
    assert 'fly' in refused(capsys, 'fly')


def test_no_or_wrong_arguments_are_one_line(capsys):
    assert 'COMMAND' in refused(capsys)
    assert '--robot' in refused(capsys, 'check', 'bag')
    assert '--speed' in refused(capsys, 'excite', '--robot', 'r', '--out', 'm', '--speed', 'fast')


@pytest.mark.parametrize('error', [
    ConfigurationError('R.yaml: joints', 'is not\nusable', 3, 'names'),
    RecordingError('bag: is damaged'), PermissionError(13, 'Permission denied', 'out.csv')])
def test_an_error_to_do_something_about_is_one_line_and_2(monkeypatch, capsys, error):
    def run(args):
        raise error
    fake_command(monkeypatch, run)
    assert cli.main(['check']) == 2
    assert str(error.args[-1] if isinstance(error, OSError) else '') in one_line(capsys)


def test_a_fault_of_the_program_is_not_hidden(monkeypatch):
    fake_command(monkeypatch, lambda args: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        cli.main(['check'])


def test_status_and_arguments_go_through(monkeypatch):
    fake_command(monkeypatch, lambda args: args.n)
    assert cli.main(['check', '--n', '7']) == 7


def test_interrupt(monkeypatch, capsys):
    def run(args):
        raise KeyboardInterrupt
    fake_command(monkeypatch, run)
    assert cli.main(['check']) == 130
    assert 'interrupted' in one_line(capsys)


@pytest.mark.parametrize('command', ['new-robot', 'check', 'excite'])
def test_help_shows_an_example(command, capsys):
    with pytest.raises(SystemExit) as exit_:
        cli.main([command, '--help'])
    assert exit_.value.code == 0
    assert f'example:\n  hand_load {command} ' in capsys.readouterr().out


def test_module_runs_and_tells_its_version():
    out = subprocess.run([sys.executable, '-m', 'hand_load_estimator', '--version'],
                         capture_output=True, text=True, check=True).stdout
    assert out.strip() == f'hand_load {__version__}'


def test_check_imports_neither_torch_nor_mujoco_nor_ros():
    code = ('import sys, contextlib\nfrom hand_load_estimator import cli\n'
            'with contextlib.suppress(SystemExit): cli.main(["check", "--help"])\n'
            'print([m for m in ("torch", "mujoco", "rclpy") if m in sys.modules])')
    out = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert out.stdout.strip().endswith('[]')
