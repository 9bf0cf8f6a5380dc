"""Find out before the work whether a result can be written and replaces nothing of the user's."""

import os
from pathlib import Path

from ..errors import ConfigurationError


def output_file(path, kind=None, inputs=()):
    """
    Return a path as Path; raises ConfigurationError where no result may be written there.

    kind: text that every file of the kind to be written holds (a version at its end aside): only
    such a file is replaced, without a kind none; inputs: what the command reads, never replaced.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise ConfigurationError(path, 'lies in a folder that does not exist', str(path.parent),
                                 todo='make the folder first')
    if path.is_dir():
        raise ConfigurationError(path, 'is a folder', todo='give the name of a file')
    _refuse_unwritable(path if path.exists() else path.parent, path)
    _refuse_input(path, inputs)
    _refuse_other(path, kind)
    return path


def output_folder(path, files=None, inputs=()):
    """
    Return the path of a folder, there or not, as Path; ConfigurationError where there can be none.

    files: {name: kind} of what is written in it; kind and inputs: as of output_file.
    """
    path = Path(path)
    there = next(p for p in (path, *path.parents) if os.path.lexists(p))
    if not there.is_dir():
        raise ConfigurationError(path, f'cannot be made: {there} is no folder',
                                 todo='give the name of a folder')
    _refuse_unwritable(there, path)
    _refuse_input(path, inputs)
    for name, kind in (files or {}).items():
        if (path / name).exists():
            output_file(path / name, kind, inputs)
    return path


def _refuse_unwritable(there, path):
    if not os.access(there, os.W_OK):
        raise ConfigurationError(path, 'cannot be written', todo='give a place of your own')


def _refuse_input(path, inputs):
    for given in filter(None, inputs):
        if path.exists() and Path(given).exists() and path.samefile(given):
            raise ConfigurationError(path, 'is what the command reads', todo='give another name')


def _refuse_other(path, kind):
    """Refuse to replace a file of another kind; a pipe, a device, an empty file holds nothing."""
    if not path.is_file() or not path.stat().st_size:
        return
    if kind is None:
        raise ConfigurationError(path, 'exists already', todo='give the name of a new file')
    mark = kind.rstrip('0123456789')
    if mark.encode() not in path.read_bytes():
        raise ConfigurationError(path, 'is there, and no earlier result of this command',
                                 allowed=f'a new file, or one with "{mark}" in it',
                                 todo='give another name')
