"""Refuse link masses of a URDF that no link has: pinocchio drops some of them without a word."""

import math

from ..errors import ConfigurationError


def refuse_masses(root, joints, where):
    """
    Raise ConfigurationError for a stated mass that is no number, negative, or zero where it moves.

    root: the URDF's element; joints: names of those whose links must have a mass if they state
    one. Frames often state a mass of zero, and links without any may lie between two joints.
    """
    moved = {joint.find('child').get('link') for joint in root.findall('joint')
             if joint.get('name') in joints}
    for link in root.findall('link'):
        mass = link.find('inertial/mass')
        if mass is None:
            continue
        name, value = link.get('name'), _number(mass.get('value'))
        if not 0.0 <= value < math.inf or (value == 0.0 and name in moved):
            raise ConfigurationError(f'{where}: link {name}', 'has a mass that no link has',
                                     str(mass.get('value')), 'a number above 0 [kg]',
                                     'correct it in the URDF')


def _number(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return math.nan
