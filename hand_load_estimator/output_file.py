"""Find out whether a result can be written before the work that makes it."""

import os
from pathlib import Path

from .errors import ConfigurationError


def output_file(path):
    """Return a path as Path; raises ConfigurationError where no file can be written there."""
    path = Path(path)
    if not path.parent.is_dir():
        raise ConfigurationError(path, 'lies in a folder that does not exist', str(path.parent),
                                 todo='make the folder first')
    if path.is_dir():
        raise ConfigurationError(path, 'is a folder', todo='give the name of a file')
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise ConfigurationError(path, 'cannot be written', todo='give a place of your own')
    return path
