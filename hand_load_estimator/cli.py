"""`hand_load <command>`: finds the command's module, reads its arguments, runs it."""

import argparse
from importlib import import_module
from importlib.util import find_spec
import os
import sys

from . import __version__
from .errors import HandLoadError

WRONG_INPUT = 2
INTERRUPTED = 130

# Told here and not in the modules, so that the list of commands imports none of them.
COMMANDS = {
    'demo': 'run simulator, estimator and controller with a live table',
    'new-robot': 'write a robot file to complete from a URDF',
    'check': 'tell whether a recording is what the robot file says',
    'excite': 'write a motion that identifies the arm, inside all its limits',
    'simulate': 'write a recording of the simulated arm',
    'identify': 'make a torque model from recordings without load or with a known one',
    'diagnose': 'find what a torque model lacks, add it, report before and after',
    'train': 'train the learned estimator for a torque model',
    'calibrate': 'make the intervals of a method without a network true',
    'learn-gp': 'learn what a torque model leaves without load, for methods gp_...',
    'estimate': 'estimate the load in a recording',
    'benchmark': 'measure accuracy and speed beside rival methods',
}


def _module(command):
    return f'{__package__}.commands.{command.replace("-", "_")}'


def available_commands():
    """Return {name: what it does} of the commands whose module is there."""
    return {name: text for name, text in COMMANDS.items() if find_spec(_module(name))}


class _OneLineParser(argparse.ArgumentParser):
    """An argument parser whose complaints are one line."""

    def error(self, message):
        """Tell what is wrong and exit."""
        print(f'{self.prog}: {message}; see `{self.prog} --help`', file=sys.stderr)
        sys.exit(WRONG_INPUT)


def _list_parser(commands):
    width = max(map(len, commands), default=0)
    listing = '\n'.join(f'  {name:<{width}}  {text}' for name, text in commands.items())
    parser = _OneLineParser(
        prog='hand_load', formatter_class=argparse.RawDescriptionHelpFormatter,
        usage='hand_load [--version] COMMAND ...',
        description='Estimate the load on a robot hand, and everything around it.',
        epilog=f'commands:\n{listing}\n\n`hand_load COMMAND --help` shows an example of each.')
    parser.add_argument('--version', action='version', version=f'hand_load {__version__}')
    parser.add_argument('command', choices=commands, metavar='COMMAND', help='one of those below')
    parser.add_argument('rest', nargs=argparse.REMAINDER, help=argparse.SUPPRESS).required = False
    return parser


def _command_parser(name, text, module):
    parser = _OneLineParser(
        prog=f'hand_load {name}', formatter_class=argparse.RawDescriptionHelpFormatter,
        description=f'{text[0].upper()}{text[1:]}.',
        epilog=f'example:\n{_indented(module.EXAMPLE)}')
    module.add_arguments(parser)
    return parser


def _indented(example):
    return '\n'.join(f'  {line.strip()}' for line in example.strip().splitlines())


def _explained(error):
    """Return an error as one line."""
    if isinstance(error, OSError) and error.filename:
        return f'{error.filename}: {error.strerror}'
    return ' '.join(str(error).split())


def main(argv=None):
    """Run one command; return its exit status, 2 for wrong input."""
    commands = available_commands()
    chosen = _list_parser(commands).parse_args(argv)
    try:
        module = import_module(_module(chosen.command))
        parser = _command_parser(chosen.command, commands[chosen.command], module)
        status = module.run(parser.parse_args(chosen.rest)) or 0
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # The reader of a pipe (head, less) has left: nobody is there to be told.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (HandLoadError, OSError) as error:
        print(f'hand_load {chosen.command}: {_explained(error)}', file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        print(f'hand_load {chosen.command}: interrupted', file=sys.stderr)
        return INTERRUPTED
