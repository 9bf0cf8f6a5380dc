"""Robot files of the measured arms, made from public figures and the URDF beside the data."""

from dataclasses import dataclass
import textwrap
from xml.etree import ElementTree

import yaml

_UNIVERSAL_ROBOTS = 'URDF (public UR figures); accelerations as in the shipped ur10e.yaml'


@dataclass(frozen=True)
class Arm:
    """
    One measured arm, as far as its URDF does not say it.

    urdf: path below the data folder; load_frame: a frame fixed to the last joint; kind: what the
    effort is (DESIGN section 4); rated_mass [kg], rated_reach [m] of its centre of mass along z
    of the load frame, by the data sheet; acceleration (n,) [rad/s^2]; sources: where the limits
    come from, a comment of the file; torque_constants (n,) [Nm/A], velocity (n,) [rad/s]: given
    only for currents, and where the URDF has no true limit.
    """

    urdf: str
    load_frame: str
    kind: str
    rated_mass: float
    rated_reach: float
    acceleration: tuple
    sources: str
    torque_constants: tuple = ()
    velocity: tuple = ()


# Gravity points down in the base frame of every one of them; `hand_load check` confirms it.
ARMS = {
    'ur10': Arm(
        'ur10/ur10.urdf', 'tool0', 'motor_torque', 10.0, 0.1, (6.0, 6.0, 8.0, 12.0, 12.0, 12.0),
        _UNIVERSAL_ROBOTS),
    'panda': Arm(
        'panda/panda.urdf', 'panda_link8', 'link_torque', 3.0, 0.1,
        (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0), 'URDF; accelerations by Franka\'s data sheet'),
    'lwr4': Arm(
        'lwr4/kuka_lwr4.urdf', 'lwr_7_link', 'link_torque', 7.0, 0.1,
        (3.0, 6.0, 4.0, 3.0, 11.0, 5.0, 3.0),
        'URDF; accelerations twice the largest recorded'),
    'kr300': Arm(
        'kr300/kr300.urdf', 'flange', 'motor_torque', 300.0, 0.3,
        (2.0, 2.0, 2.0, 15.0, 4.0, 18.0),
        'torques 50 Nm at the motor times gear ratio (URDF); the URDF\'s velocities are '
        'placeholders: twice the largest recorded instead, accelerations too',
        velocity=(0.9, 0.9, 0.9, 1.2, 1.1, 1.6)),
    'staubli_tx40': Arm(
        'staubli_tx40/tx40.urdf', 'tool0', 'motor_torque', 1.7, 0.1,
        (50.0, 50.0, 93.0, 104.0, 72.0, 140.0),
        'URDF; accelerations twice the largest recorded'),
    # Torque constants of joints 2-5: target torque over target current at rest (about.yaml);
    # joint 1: fitted in motion; joint 6 never moves and carries nothing: that of joint 5.
    'nist_ur5': Arm(
        'nist_ur5/ur5.urdf', 'tool0', 'motor_current', 5.0, 0.1,
        (6.0, 6.0, 8.0, 12.0, 12.0, 12.0), _UNIVERSAL_ROBOTS,
        torque_constants=(12.0, 11.597, 11.603, 8.443, 8.539, 8.539)),
}
# Doubt about torque constants [relative]: two published sets of the UR10e's differ by 10-13 %.
_CONSTANTS_STD = 0.05


def _moving_joints(urdf):
    """Return (names, velocity limits, effort limits) of a URDF's moving joints, base first."""
    joints = [joint for joint in ElementTree.parse(urdf).getroot().iter('joint')
              if joint.get('type') == 'revolute']
    limits = [joint.find('limit').attrib for joint in joints]
    return ([joint.get('name') for joint in joints],
            [float(limit['velocity']) for limit in limits],
            [float(limit['effort']) for limit in limits])


def _rated_load(arm):
    # No data sheet gives one moment of inertia: a ball whose radius is its distance.
    inertia = round(0.4 * arm.rated_mass * arm.rated_reach ** 2, 6)
    return {'mass': arm.rated_mass, 'com': [0.0, 0.0, arm.rated_reach],
            'inertia': [inertia, 0.0, 0.0, inertia, 0.0, inertia]}


def robot_content(name, data):
    """Return the mapping of the robot file of ARMS[name]; data: Path of the data folder."""
    arm = ARMS[name]
    urdf = (data / arm.urdf).resolve()
    joints, velocity, torque = _moving_joints(urdf)
    effort = {'kind': arm.kind, 'includes_configured_load': False}
    if arm.torque_constants:
        effort.update(torque_constants=list(arm.torque_constants),
                      torque_constants_std=_CONSTANTS_STD)
    return {'name': name, 'urdf': str(urdf), 'joints': joints, 'load_frame': arm.load_frame,
            'gravity': [0.0, 0.0, -9.81], 'reference_temperature': 25.0,
            'rated_load': _rated_load(arm), 'effort': effort,
            'max_velocity': list(arm.velocity) or velocity,
            'max_acceleration': list(arm.acceleration), 'max_torque': torque}


def write_robot_file(name, data, folder):
    """Write the robot file of ARMS[name] into a folder; return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f'{name}.yaml'
    text = yaml.safe_dump(robot_content(name, data), sort_keys=False, default_flow_style=None,
                          width=99)
    told = textwrap.fill(f'Limits: {ARMS[name].sources}.', 97)
    comment = textwrap.indent(f'{name}, for the recordings in {data}.\n{told}', '# ')
    path.write_text(f'{comment}\n{text}', encoding='utf-8')
    return path
