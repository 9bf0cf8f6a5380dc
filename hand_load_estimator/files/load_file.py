"""
Read a load file: `none`, or mass with optional com and inertia, in the load frame.

`assumed: true` says that the load was not weighed but concluded from the torques: good enough to
identify a model with, no truth to judge an estimate by.
"""

from pathlib import Path

import numpy as np
import yaml

from ..errors import ConfigurationError
from ..load import LoadParameters
from .configuration import Section, read_yaml

ASSUMED = 'assumed'


def parse_load(section):
    """Return (load, known): known names which of mass, com, inertia were stated."""
    known = ['mass']
    mass = section.number('mass', 0.0, 1000.0)
    com, six = np.zeros(3), np.zeros(6)
    if section.has('com'):
        com = section.vector('com', 3, -5.0, 5.0)
        known.append('com')
    if section.has('inertia'):
        six = section.vector('inertia', 6)
        known.append('inertia')
    section.refuse_unknown()
    load = LoadParameters.from_message(np.concatenate([[mass], com, six]))
    if not load.is_physical():
        section.fail('inertia', 'belongs to no real body', list(map(float, six)),
                     'an inertia about the centre of mass whose principal moments satisfy the '
                     'triangle inequality, all zero for a zero mass')
    return load, tuple(known)


def says_none(path):
    """Tell whether a load file says `none`."""
    path = Path(path)
    return (path.is_file()
            and path.read_text(encoding='utf-8', errors='replace').strip() == 'none')


def read_load_file(path):
    """
    Return (load, known) of a load.yaml; raises ConfigurationError.

    known holds ASSUMED, too, where the file says so.
    """
    if says_none(path):
        return LoadParameters(), ('mass', 'com', 'inertia')
    section = Section(read_yaml(path), path)
    assumed = section.has(ASSUMED) and section.flag(ASSUMED)
    load, known = parse_load(section)
    return load, known + (ASSUMED,) * assumed


def placed(load, known, where):
    """Return a load whose centre of mass is known; refuse one that has only a mass."""
    if load.mass > 0.0 and 'com' not in known:
        raise ConfigurationError(where, 'gives a mass without its com, and its torque depends on '
                                 'where it is', allowed='com: [x, y, z] [m] in the load frame '
                                 'beside the mass', todo='add it, or do without the load')
    return load


def write_load_file(path, load):
    """Write what read_load_file reads."""
    vector = load.to_message()
    content = {'mass': float(vector[0]), 'com': vector[1:4].tolist(),
               'inertia': vector[4:].tolist()}
    Path(path).write_text(yaml.safe_dump(content, sort_keys=False, default_flow_style=None),
                          encoding='utf-8')


def load_of_argument(text):
    """Return (load, known) of a --load argument: `none` or a file."""
    if text == 'none':
        return LoadParameters(), ('mass', 'com', 'inertia')
    if not Path(text).is_file():
        raise ConfigurationError('--load', 'is neither `none` nor a file', text,
                                 'none or the path of a load.yaml')
    return read_load_file(text)
