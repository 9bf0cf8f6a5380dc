"""The robot file: everything the package knows of an arm, checked when it is read."""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import ConfigurationError
from ..load import LoadParameters
from .configuration import Section, read_yaml
from .load_file import parse_load, placed

EFFORT_KINDS = ('motor_torque', 'link_torque', 'motor_current')
# A hand on fewer moves in too few ways to tell of an arm and a load what is asked here.
LEAST_JOINTS = 3
POSITION_SOURCES = ('feedback', 'command')


@dataclass(frozen=True)
class Effort:
    """
    What the effort field of JointState means.

    kind: one of EFFORT_KINDS; torque_constants (n,) [Nm/A at the joint, signed; 1 for torques];
    torque_constants_std: their relative standard deviation; configured_load: the load the
    robot's own controller has already taken off the effort, or None.
    """

    kind: str
    torque_constants: np.ndarray
    torque_constants_std: float
    configured_load: LoadParameters | None


@dataclass(frozen=True)
class JointLimits:
    """
    Limits per joint, (n,) each.

    lower, upper [rad] from the URDF; velocity [rad/s]; acceleration [rad/s^2]; torque [Nm]
    (drive peak, at the joint); allowed_torque: fraction of it that planning may use.
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray
    allowed_torque: float


@dataclass(frozen=True)
class RobotFile:
    """
    The checked content of a robot file; `content` is a self-contained copy of it.

    command_lag [s]: how far the arm is behind its commands where joint states hold these, None
    where they hold what was measured.
    """

    name: str
    urdf: str
    joints: tuple
    load_frame: str
    gravity: np.ndarray
    reference_temperature: float
    rated_load: LoadParameters
    effort: Effort
    command_lag: float | None
    max_velocity: np.ndarray
    max_acceleration: np.ndarray
    max_torque: np.ndarray
    allowed_torque: float
    content: dict
    where: str


def _placed_load(section):
    """Return the LoadParameters of a mapping, whose com may not be left out."""
    return placed(*parse_load(section), section.where)


def _effort(section, n):
    kind = section.text('kind', EFFORT_KINDS)
    constants, doubt = np.ones(n), 0.0
    if kind == 'motor_current':
        constants = section.vector('torque_constants', n)
        if np.any(constants == 0.0):
            section.fail('torque_constants', 'has a zero', constants.tolist(),
                         'signed, not zero [Nm/A at the joint]')
        doubt = section.number('torque_constants_std', 0.0, 1.0)
    else:
        for key in ('torque_constants', 'torque_constants_std'):
            if section.has(key):
                section.fail(key, f'does not go with kind {kind}', section.get(key, ''),
                             'only with kind motor_current')
    configured = None
    if section.flag('includes_configured_load'):
        configured = _placed_load(section.section('configured_load'))
    section.refuse_unknown()
    return Effort(kind, constants, doubt, configured)


def _command_lag(section):
    """Return the lag [s] of commanded positions, or None for measured ones."""
    if not section.has('position'):
        return None
    position = section.section('position')
    commanded = position.text('source', POSITION_SOURCES) == 'command'
    lag = position.number('lag', 0.0, 0.2) if commanded else None
    position.refuse_unknown()
    return lag


def _urdf(section, folder):
    """Return the URDF's text: inline in a self-contained copy, else a path beside the file."""
    value = section.text('urdf')
    if value.lstrip().startswith('<'):
        return value
    path = Path(folder) / value
    if not path.is_file():
        section.fail('urdf', 'names a file that is not there', str(path),
                     'a path relative to the robot file')
    try:
        return path.read_text(encoding='utf-8-sig')
    except UnicodeDecodeError:
        return _of_declared_encoding(section, path)


def _of_declared_encoding(section, path):
    """Return the text of a URDF that is not UTF-8, without the declaration of its encoding."""
    try:
        return ElementTree.tostring(ElementTree.parse(path).getroot(), encoding='unicode')
    # An encoding that Python does not know is a LookupError or a ValueError.
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        section.fail('urdf', f'names a file that cannot be read ({error})', str(path),
                     'a URDF in UTF-8, or in the encoding that it declares')


def parse_robot(content, where, folder='.'):
    """
    Return the RobotFile of a mapping.

    `folder`: where a relative `urdf` is looked for. Raises ConfigurationError.
    """
    section = Section(content, where)
    joints = section.names('joints')
    n = len(joints)
    if n < LEAST_JOINTS:
        section.fail('joints', 'are too few', list(joints), f'{LEAST_JOINTS} or more')
    gravity = section.vector('gravity', 3)
    if not 1.0 < np.linalg.norm(gravity) < 30.0:
        section.fail('gravity', 'is not a gravity', gravity.tolist(),
                     '[x, y, z] in the base frame [m/s^2], norm 1 to 30; upright is [0, 0, -9.81]')
    rated = _placed_load(section.section('rated_load'))
    if rated.mass <= 0.0:
        section.fail('rated_load', 'has no mass', rated.mass, 'the mass of the data sheet [kg]')
    urdf = _urdf(section, folder)
    robot = RobotFile(
        name=section.text('name'), urdf=urdf, joints=joints,
        load_frame=section.text('load_frame'), gravity=gravity,
        reference_temperature=section.number('reference_temperature', -50.0, 150.0),
        rated_load=rated, effort=_effort(section.section('effort'), n),
        command_lag=_command_lag(section),
        max_velocity=section.vector('max_velocity', n, 1e-6, 100.0),
        max_acceleration=section.vector('max_acceleration', n, 1e-6, 1000.0),
        max_torque=section.vector('max_torque', n, 1e-6, 1e6),
        allowed_torque=(section.number('allowed_torque', 0.05, 1.0)
                        if section.has('allowed_torque') else 0.8),
        content={**content, 'urdf': urdf}, where=str(where))
    section.refuse_unknown()
    return robot


def read_robot_file(path):
    """Return the RobotFile of a YAML file; raises ConfigurationError."""
    path = Path(path)
    if not path.is_file():
        raise ConfigurationError(path, 'is not there', allowed='the path of a robot file',
                                 todo='`hand_load new-robot` writes one from a URDF')
    return parse_robot(read_yaml(path), path, path.parent)
