"""Draft a robot file from a URDF: what the URDF says, and marks where a person must say it."""

from dataclasses import dataclass
import json
import math
import os
from pathlib import Path
import xml.etree.ElementTree as ElementTree

import yaml

from ..errors import ConfigurationError
from .robot_file import LEAST_JOINTS

TO_COMPLETE = 'TO_COMPLETE'
_MOVABLE = ('revolute', 'continuous', 'prismatic')
# Where a chain ends by habit (REP-199); a gripper's fingers behind it are not part of the arm.
_USUAL_TIPS = ('tool0', 'flange', 'tcp', 'ee_link')


@dataclass(frozen=True)
class ChainJoint:
    """One movable joint: name, type, and lower, upper, velocity, effort or None where not said."""

    name: str
    kind: str
    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None


@dataclass(frozen=True)
class Chain:
    """
    The arm found in a URDF; frames are those fixed to the last joint, tip is one of them.

    beyond: names of the movable joints behind the arm's last one, a gripper's.
    """

    name: str
    base: str
    tip: str
    joints: tuple
    frames: tuple
    massless: tuple
    beyond: tuple


def _number(element, attribute):
    try:
        value = float(element.get(attribute))
    except (AttributeError, TypeError, ValueError):
        return None
    return value if math.isfinite(value) else None


def _positive(element, attribute):
    value = _number(element, attribute)
    return value if value is not None and value > 0.0 else None


def _chain_joint(element):
    limit = element.find('limit')
    bounded = element.get('type') != 'continuous'
    return ChainJoint(element.get('name'), element.get('type'),
                      _number(limit, 'lower') if bounded else None,
                      _number(limit, 'upper') if bounded else None,
                      _positive(limit, 'velocity'), _positive(limit, 'effort'))


def _parse(path):
    try:
        root = ElementTree.parse(path).getroot()
    except FileNotFoundError:
        raise ConfigurationError(path, 'is not there', allowed='the path of a URDF') from None
    # An encoding that Python does not know is a LookupError or a ValueError.
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise ConfigurationError(path, f'is not XML ({error})', allowed='a URDF') from None
    if root.tag != 'robot':
        raise ConfigurationError(path, 'is not a URDF', f'<{root.tag}>', '<robot>')
    # ElementTree keeps the namespace of a tag in braces.
    if any('xacro' in element.tag for element in root.iter() if isinstance(element.tag, str)):
        raise ConfigurationError(path, 'is a xacro, not a URDF',
                                 todo=f'expand it: `xacro {path} > robot.urdf`')
    return root


def _refuse_broken(path, root, links):
    """Refuse links and joints without a name, and joints whose ends are no links."""
    for element in (*root.findall('link'), *root.findall('joint')):
        if not element.get('name'):
            raise ConfigurationError(path, f'has a {element.tag} without a name',
                                     todo='give it one')
    for joint in root.findall('joint'):
        for end in ('parent', 'child'):
            found = joint.find(end)
            link = None if found is None else found.get('link')
            if link not in links:
                raise ConfigurationError(f'{path}: joint {joint.get("name")}: {end}',
                                         'is not a link of the URDF', str(link),
                                         ', '.join(links))


def _path_to(file, link, parent_joint):
    """Return the joint elements from the root to a link; file: the URDF's path, for messages."""
    path = []
    while link in parent_joint:
        if len(path) == len(parent_joint):
            raise ConfigurationError(f'{file}: link {link}', 'is behind itself',
                                     allowed='links that branch from one')
        path.append(parent_joint[link])
        link = path[-1].find('parent').get('link')
    return path[::-1]


def _movable(path):
    return [element for element in path if element.get('type') != 'fixed']


def _choose_tip(links, paths):
    """Return the usual tip where there is one, else the end of the arm with most joints."""
    usual = [link for link in _USUAL_TIPS if link in links and _movable(paths[link])]
    if usual:
        return usual[0]
    arm = [link for link in links if not _ends_sliding(paths[link])]
    return max(arm, key=lambda link: (len(_movable(paths[link])), len(paths[link])))


def _ends_sliding(path):
    """Tell whether the last joint slides after others that turn, as a gripper's finger does."""
    kinds = [element.get('type') for element in _movable(path)]
    return 'prismatic' in kinds[-1:] and kinds != ['prismatic'] * len(kinds)


def _fixed_to_last_joint(links, paths, tip):
    last = _movable(paths[tip])[-1]
    return tuple(link for link in links
                 if _movable(paths[link]) and _movable(paths[link])[-1] is last)


def _beyond(paths, tip):
    """Return the names of the movable joints behind the last one on the way to the tip."""
    arm = _movable(paths[tip])
    behind = {element.get('name'): None for path in paths.values()
              if _movable(path)[:len(arm)] == arm for element in _movable(path)[len(arm):]}
    return tuple(behind)


def _massless(root, moved):
    """Return the links of the arm's joints that have no mass: the rigid body misses them."""
    masses = {link.get('name'): _number(link.find('inertial/mass'), 'value')
              for link in root.findall('link')}
    return tuple(link for link in moved if not masses.get(link))


def read_chain(path, tip=None):
    """Return the Chain of a URDF file to `tip` (default: the usual or farthest one)."""
    root = _parse(path)
    links = [link.get('name') for link in root.findall('link')]
    _refuse_broken(path, root, links)
    parent_joint = {joint.find('child').get('link'): joint for joint in root.findall('joint')}
    if tip is not None and tip not in links:
        raise ConfigurationError('--tip', 'is not a link of the URDF', tip, ', '.join(links))
    paths = {link: _path_to(path, link, parent_joint) for link in links}
    if not any(_movable(p) for p in paths.values()):
        raise ConfigurationError(path, 'has no movable joint', allowed=', '.join(_MOVABLE))
    tip = tip or _choose_tip(links, paths)
    joints = _movable(paths[tip])
    if not joints:
        raise ConfigurationError('--tip', 'is not behind any movable joint', tip,
                                 ', '.join(link for link in links if _movable(paths[link])))
    if len(joints) < LEAST_JOINTS:
        raise ConfigurationError(
            f'{path}: chain to {tip}', 'has too few movable joints',
            ', '.join(joint.get('name') for joint in joints), f'{LEAST_JOINTS} or more',
            'give the link at the end of the arm with --tip')
    for joint in joints:
        if joint.get('type') not in _MOVABLE:
            raise ConfigurationError(f'{path}: joint {joint.get("name")}', 'is not usable',
                                     joint.get('type'), ', '.join(_MOVABLE))
    moved = [joint.find('child').get('link') for joint in joints]
    base = next(link for link in links if link not in parent_joint)
    return Chain(root.get('name') or Path(path).stem, base, tip, tuple(map(_chain_joint, joints)),
                 _fixed_to_last_joint(links, paths, tip), _massless(root, moved),
                 _beyond(paths, tip))


def _text(value):
    """Return a name as YAML, quoted where YAML would read something else."""
    try:
        plain = yaml.safe_load(f'[{value}]') == [value]
    # A date that no calendar has is a plain ValueError.
    except (yaml.YAMLError, ValueError):
        plain = False
    return value if plain else json.dumps(value)


def _list(values):
    return '[' + ', '.join(TO_COMPLETE if v is None else f'{v:g}' for v in values) + ']'


def _range(joint):
    if joint.lower is None or joint.upper is None:
        return 'without position limits'
    return f'{joint.lower:.3f} to {joint.upper:.3f} {"m" if joint.kind == "prismatic" else "rad"}'


def draft_robot_file(chain, urdf, out):
    """Return the text of the robot file `out` for a chain of the file `urdf`."""
    relative = os.path.relpath(urdf, Path(out).parent)
    joints = ', '.join(_text(joint.name) for joint in chain.joints)
    ranges = '\n'.join(f'#   {j.name}: {j.kind}, {_range(j)}' for j in chain.joints)
    one_line = '[' + ', '.join([TO_COMPLETE] * len(chain.joints)) + ']'
    return f"""\
# Drafted by `hand_load new-robot` from {Path(urdf).name}.
# Replace every {TO_COMPLETE}; read every line marked "check". The file is refused until then.
name: {_text(chain.name)}
urdf: {_text(relative)}    # relative to this file

# The movable joints from {chain.base} to {chain.tip}, in order; position limits are the URDF's:
{ranges}
joints: [{joints}]

# Check: the frame in which the load is stated; a frame fixed to {chain.joints[-1].name}:
#   {', '.join(chain.frames)}
load_frame: {_text(chain.tip)}

# Check: [m/s^2] in the axes of {chain.base}. Upright [0, 0, -9.81], ceiling [0, 0, 9.81],
# wall [9.81, 0, 0] or another horizontal axis. `hand_load check` compares it with a recording.
gravity: [0.0, 0.0, -9.81]

reference_temperature: 25.0    # check: [degC] at which friction parameters are stated

rated_load:                    # data sheet
  mass: {TO_COMPLETE}            # [kg]
  com: {_list([None] * 3)}    # [m] in the load frame, where the mass may be
  inertia: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]   # check: [kg m^2] about the com: xx xy xz yy yz zz

effort:
  # What the effort field of joint_states means:
  #   motor_torque   [Nm] at the joint, friction and rotor included (most arms)
  #   link_torque    [Nm] from torque sensors behind the gear
  #   motor_current  [A]; then add the two lines below
  kind: {TO_COMPLETE}
  # torque_constants: {one_line}   # [Nm/A at the joint], signed
  # torque_constants_std: 0.05   # relative standard deviation
  # Check: true when the driver takes the load set on the robot off the effort; then add
  # configured_load: {{mass: ..., com: [...], inertia: [...]}}
  includes_configured_load: false

max_velocity: {_list(j.velocity for j in chain.joints)}    # [rad/s] URDF
max_acceleration: {one_line}    # [rad/s^2] what the drives follow without load; not in a URDF
# Check: [Nm] drive peak at the joint; the URDF's effort limits
max_torque: {_list(j.effort for j in chain.joints)}
allowed_torque: 0.8            # check: fraction of max_torque used in planning
"""


def values_to_complete(chain):
    """Return the keys that carry TO_COMPLETE in the draft of a chain."""
    keys = ['rated_load.mass', 'rated_load.com', 'effort.kind', 'max_acceleration']
    if any(joint.velocity is None for joint in chain.joints):
        keys.append('max_velocity')
    if any(joint.effort is None for joint in chain.joints):
        keys.append('max_torque')
    return tuple(keys)
