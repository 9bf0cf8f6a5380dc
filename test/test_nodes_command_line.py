"""Arguments of a node: --help explains, what rclpy would ignore is refused, ROS's go through."""

from importlib import import_module

import pytest

from hand_load_estimator.nodes import command_line

NODES = ('simulator', 'estimator', 'controller')


def table_of(node):
    """Return the parameter table of a node."""
    module = import_module(f'hand_load_estimator.nodes.{node}_parameters')
    return getattr(module, f'{node.upper()}_PARAMETERS')


@pytest.fixture
def ran(monkeypatch):
    """Return the list of the arguments that nodes were run with."""
    runs = []
    monkeypatch.setattr(command_line, 'run_node', lambda _, args: runs.append(args) or 0)
    return runs


@pytest.mark.parametrize('node', NODES)
def test_help_shows_the_table_and_starts_nothing(start, node):
    """`simulator_node --help` published the joint states of an arm that was not there."""
    process = start(node, '--help')
    assert process.wait(30.0) == 0
    said = process.output
    assert f'{node}_node --ros-args -p robot:=my_arm.yaml' in said
    words = ' '.join(said.split())
    for row in table_of(node):
        assert f' {row.name}' in words and row.description in words
        assert (row.allowed or row.kind) in words and row.unit in words
    assert max(map(len, said.partition('parameters:')[2].splitlines())) < 100


@pytest.mark.parametrize('node', NODES)
@pytest.mark.parametrize('arguments', [('robot:=arm.yaml',), ('-p', 'robot:=arm.yaml')])
def test_a_parameter_without_ros_args_is_refused_with_what_was_meant(start, node, arguments):
    process = start(node, *arguments)
    assert process.wait(30.0) == 2
    assert process.output == (
        f'error: {node}_node: arguments outside --ros-args have no effect; got '
        f'{" ".join(arguments)!r}; allowed: --help; did you mean --ros-args -p robot:=arm.yaml '
        '?\n')


@pytest.mark.parametrize('arguments, hint', [
    (['use_sim_time:=true', '-r', 'a:=b'],
     'did you mean --ros-args -p use_sim_time:=true -r a:=b ?'),
    (['--params-file', 'p.yaml'], 'did you mean --ros-args --params-file p.yaml ?'),
    (['robott:=arm.yaml'], '--help lists them'), (['arm.yaml'], '--help lists them'),
    (['--params-file'], '--help lists them'),
    (['--ros-args', '-p', 'robot:=ur10e', '--', 'rate:=100.0'],
     'did you mean --ros-args -p rate:=100.0 ?')])
def test_other_arguments_are_refused_too(ran, capsys, arguments, hint):
    status = command_line.run_from_command_line('simulator', None, table_of('simulator'),
                                                arguments)
    error = capsys.readouterr().err
    assert status == 2 and not ran
    assert error.endswith(f'{hint}\n') and error.count('\n') == 1


@pytest.mark.parametrize('arguments', [
    [], ['--ros-args'],
    # As ros2 launch calls it.
    ['--ros-args', '-r', '__node:=simulator', '-r', '__ns:=/', '--params-file', 'a.yaml',
     '--params-file', 'b.yaml'],
    ['--ros-args', '-p', 'robot:=ur10e', '--', '--ros-args', '-r', '__ns:=/left', '--']])
def test_what_ros_takes_goes_through(ran, arguments):
    assert command_line.run_from_command_line('simulator', None, table_of('simulator'),
                                              arguments) == 0
    assert ran == [arguments]


def test_the_process_gives_the_arguments_where_nobody_else_does(ran, monkeypatch, capsys):
    monkeypatch.setattr('sys.argv', ['simulator_node', '-h'])
    assert command_line.run_from_command_line('simulator', None, table_of('simulator')) == 0
    assert not ran and 'usage: simulator_node' in capsys.readouterr().out
