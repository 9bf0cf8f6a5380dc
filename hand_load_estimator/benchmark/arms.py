"""
The arms suite: three more arms, made from URDFs of PyPI's example-robot-data.

Each robot file is the draft of `hand_load new-robot` with the figures below filled in. The plant
of such an arm is as hard as the UR10e's: friction, rotors, heat and noise go by each joint's peak
torque (plant/difficulty.py). No learned artefact belongs to them, so methods that need one fall
back on `bayes` and are not shown twice.
"""

from dataclasses import dataclass
from importlib.metadata import distribution, PackageNotFoundError
from pathlib import Path

import numpy as np
import yaml

from ..errors import ConfigurationError
from ..files.robot_draft import draft_robot_file, read_chain
from ..plant.difficulty import by_size, DEFAULT

PACKAGE = 'example-robot-data'
_ROBOTS = 'cmeel.prefix/share/example-robot-data/robots'


@dataclass(frozen=True)
class ExtraArm:
    """
    What a URDF does not say of an arm.

    urdf: below the package's robots; tip: load frame; kind of effort; mass [kg] of the rated
    load, reach [m] of its centre of mass along z of the load frame; acceleration (n,) [rad/s^2];
    source of these figures.
    """

    urdf: str
    tip: str
    kind: str
    mass: float
    reach: float
    acceleration: tuple
    source: str


ARMS = {
    'ur5': ExtraArm('ur_description/urdf/ur5_robot.urdf', 'tool0', 'motor_torque', 5.0, 0.1,
                    (6.0, 6.0, 8.0, 12.0, 12.0, 12.0),
                    'data sheet 5 kg; accelerations as of the ur10e'),
    'panda': ExtraArm('panda_description/urdf/panda.urdf', 'panda_link8', 'link_torque', 3.0, 0.1,
                      (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
                      'data sheet 3 kg and accelerations; torque sensors behind the gears'),
    'xarm7': ExtraArm('xarm_description/urdf/xarm7.urdf', 'link_eef', 'motor_torque', 3.5, 0.08,
                      (8.0, 8.0, 8.0, 10.0, 12.0, 15.0, 15.0),
                      'data sheet 3.5 kg; accelerations chosen: none is published')}


def urdf_of(arm):
    """Return the Path of an ExtraArm's URDF; raises ConfigurationError without the package."""
    try:
        path = Path(distribution(PACKAGE).locate_file(f'{_ROBOTS}/{arm.urdf}'))
    except PackageNotFoundError:
        raise ConfigurationError('--suite', f'arms needs the package {PACKAGE}', 'arms',
                                 todo=f'`pip install {PACKAGE}`, or leave the suite out') \
            from None
    return path


def write_arm(name, urdf, folder):
    """Write the robot file of ARMS[name] for a URDF into a folder; return its path."""
    arm, folder = ARMS[name], Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f'{name}.yaml'
    chain = read_chain(urdf, arm.tip)
    content = yaml.safe_load(draft_robot_file(chain, urdf, path))
    # No data sheet gives a moment of inertia: a ball whose radius is its distance.
    moment = round(0.4 * arm.mass * arm.reach ** 2, 6)
    content['rated_load'] = {'mass': arm.mass, 'com': [0.0, 0.0, arm.reach],
                             'inertia': [moment, 0.0, 0.0, moment, 0.0, moment]}
    content['name'] = name
    content['effort']['kind'] = arm.kind
    content['max_acceleration'] = list(arm.acceleration)
    text = f'# {name}, drafted by `hand_load new-robot`; {arm.source}.\n' + yaml.safe_dump(
        content, sort_keys=False, default_flow_style=None, width=99)
    if not path.exists() or path.read_text('utf-8') != text:
        path.write_text(text, encoding='utf-8')
    return path


def friction_told(robot):
    """Return a sentence with the plant's friction and noise levels of a Robot's joints."""
    def told(figures):
        """Return as text what the plant's table gives this robot's joints."""
        return ', '.join(f'{value:.2g}' for value in by_size(figures, robot.limits.torque))
    noise = np.asarray(by_size(DEFAULT.torque_noise, robot.limits.torque))
    friction = ('none in the effort (sensors behind the gears)'
                if robot.effort.kind == 'link_torque' else
                f'Coulomb {told(DEFAULT.coulomb)} Nm, viscous {told(DEFAULT.viscous)} Nm s/rad at '
                '25 degC')
    return (f'{robot.n} axes, rated load {robot.rated_load.mass:g} kg; friction: {friction}; '
            f'torque noise {", ".join(f"{value:.2g}" for value in noise)} Nm')
