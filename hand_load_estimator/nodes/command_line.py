"""The command line of a node: --help, and a refusal of what rclpy would silently ignore."""

from pathlib import Path
import re
import sys
import textwrap

import yaml

from ..errors import ConfigurationError
from ..files.shared_files import share_folder
from .runner import run_node

_WIDTH = 98
# rclpy declares it in every node.
_RCLPY_OWN = ('use_sim_time',)
_TAKE_A_VALUE = ('-p', '--param', '-r', '--remap', '--params-file', '--log-level', '-e',
                 '--enclave')


def run_from_command_line(name, make_node, table, args=None):
    """
    Answer --help, refuse arguments outside --ros-args, or run the node; return the exit code.

    name: of the node; make_node: returns it; table: its parameters; args: what follows the
    executable's name, None: this process's.
    """
    outside = _outside_ros_args(sys.argv[1:] if args is None else args)
    if '-h' in outside or '--help' in outside:
        print(help_text(name, table))
        return 0
    if outside:
        print(f'error: {_refusal(name, table, outside)}', file=sys.stderr)
        return 2
    given = sys.argv[1:] if args is None else args

    def make():
        node = make_node()
        for told in _ignored_files(node, given):
            node.get_logger().warning(told)
        return node
    return run_node(make, args)


def _ignored_files(node, args):
    """Return [a sentence] where parameter files say nothing to a node, as rcl does not tell."""
    name = node.get_fully_qualified_name()
    files = [file for key, file in zip(args, args[1:]) if key == '--params-file']
    return [f'{file}: has no parameters for {name}; its section must be called {name}, or '
            f'/**/{node.get_name()}' for file in files
            if not any(_is_of(section, name) for section in _sections(file))]


def _sections(file):
    """Return what the sections of a parameter file are called."""
    # rcl has read it: it is a mapping.
    return [str(name) for name in yaml.safe_load(Path(file).read_text('utf-8')) or ()]


def _is_of(section, name):
    """Tell whether a section is for the node of a full name; ** stands for any namespaces."""
    pattern = re.escape('/' + section.lstrip('/')).replace(r'/\*\*', '(/[^/]+)*').replace(
        r'\*', '[^/]+')
    return re.fullmatch(pattern, name) is not None


def _outside_ros_args(args):
    """Return the arguments that stand in no `--ros-args ... [--]`, as rcl tells them apart."""
    outside, within = [], False
    for arg in args:
        if arg == '--ros-args':
            within = True
        elif within:
            within = arg != '--'
        else:
            outside.append(arg)
    return outside


def _refusal(name, table, outside):
    meant = _meant(table, outside)
    return ConfigurationError(
        f'{name}_node', 'arguments outside --ros-args have no effect', ' '.join(outside), '--help',
        f'did you mean --ros-args {meant} ?' if meant else
        'give parameters as --ros-args -p NAME:=VALUE; --help lists them')


def _meant(table, outside):
    """Return the arguments as they are right behind --ros-args; empty where that is a guess."""
    known = {*(row.name for row in table), *_RCLPY_OWN}
    meant, rest = [], list(outside)
    while rest:
        arg = rest.pop(0)
        if arg in _TAKE_A_VALUE and rest:
            meant += [arg, rest.pop(0)]
        elif ':=' in arg and arg.split(':=')[0] in known:
            meant += ['-p', arg]
        else:
            return ''
    return ' '.join(meant)


def help_text(name, table):
    """Return what --help prints: how to pass parameters, and all of the table."""
    executable, file = f'{name}_node', share_folder() / 'config' / f'{name}.yaml'
    return '\n'.join([
        f'usage: {executable} [-h]',
        f'       {executable} [--ros-args [-p NAME:=VALUE]... [--params-file FILE]... '
        '[-r FROM:=TO]...]', '',
        'Pass parameters by name, from a file, or both:',
        f'  {executable} --ros-args -p robot:=my_arm.yaml',
        f'  {executable} --ros-args --params-file {file}',
        f'Topics and services: README.md, or `ros2 node info /{name}` while it runs.', '',
        'parameters:', *(_row_text(row) for row in table)])


def _row_text(row):
    unit = f' [{row.unit}]' if row.unit else ''
    default = 'must be given' if row.todo else f"default {row.default_text or 'empty'}"
    change = '' if row.read_only else ' (can be changed while running)'
    lines = (f'  {row.name}{unit}: {default}; allowed: {row.allowed or row.kind}',
             f'      {row.description}{change}')
    return '\n'.join(textwrap.fill(line, _WIDTH, subsequent_indent=6 * ' ') for line in lines)
