"""`hand_load excite`: a motion that identifies the arm, inside all its limits."""

from pathlib import Path
import sys
import time

import numpy as np

from ..errors import ConfigurationError
from ..files.output_file import output_file
from ..files.shared_files import find_shared
from ..files.trajectory_message import write_trajectory_message
from ..motions.excitation import make_box, Search
from ..motions.excitation_information import INDEPENDENT_RATE
from ..motions.excitation_limits import (check_centre, check_chosen_centre, choose_centre,
                                         torque_use)
from ..motions.trajectory import write_trajectory_csv
from ..number_argument import number
from ..robot import load_robot

EXAMPLE = """
hand_load excite --robot my_arm.yaml --out excite.csv
hand_load excite --robot ur10e --out excite --centre=0,-1.6,1.2,-1.2,-1.5,0 --speed 0.3
"""
# [Nm per Nm of max_torque] what a torque model leaves unexplained, where nothing is stated.
_DEFAULT_NOISE = 0.005


def add_arguments(parser):
    """Add the arguments of excite."""
    parser.add_argument('--robot', metavar='R.yaml', required=True,
                        help='robot file, or the short name of a shipped one')
    parser.add_argument('--out', metavar='MOTION', required=True,
                        help='motion to write: MOTION.csv and, as a JointTrajectory message, '
                             'MOTION.yaml')
    parser.add_argument('--duration', metavar='S', type=float, default=60.0,
                        help='length at full speed [s] (default: %(default)g)')
    parser.add_argument('--centre', metavar='Q1,Q2,...',
                        help='joint positions [rad] where the motion begins and ends (default: '
                             'where the arm has most room above its base)')
    parser.add_argument('--reach', metavar='RAD', type=float, default=1.2,
                        help='farthest from the centre, per joint [rad] (default: %(default)g)')
    parser.add_argument('--speed', metavar='SCALE', type=float, default=1.0,
                        help='the same path at a share of its speed, at 0.5 twice as long '
                             '(default: %(default)g)')
    parser.add_argument('--noise', metavar='NM,NM,...',
                        help='torque error per joint [Nm] for the expected covariance '
                             f'(default: {_DEFAULT_NOISE:g} x max_torque)')
    parser.add_argument('--seed', metavar='N', type=number(0, 2 ** 31, int), default=0,
                        help='another number gives another motion (default: %(default)s)')


def _numbers(text, option, robot):
    try:
        values = np.array([float(part) for part in text.split(',')])
    except ValueError:
        values = np.array([])
    if values.shape != (robot.n,) or not np.all(np.isfinite(values)):
        raise ConfigurationError(option, 'is not usable', text,
                                 f'{robot.n} numbers: {", ".join(robot.joints)}')
    return values


def _within(option, value, low, high):
    if not low <= value <= high:
        raise ConfigurationError(option, 'is not usable', value, f'{low:g} to {high:g}')


def _outputs(out):
    base = Path(out).with_suffix('') if Path(out).suffix in ('.csv', '.yaml') else Path(out)
    return [output_file(base.with_name(base.name + suffix)) for suffix in ('.csv', '.yaml')]


class _Progress:
    """Tell on stderr, about once a second, how far the search is."""

    def __init__(self):
        self._next = time.monotonic() + 1.0

    def __call__(self, done, total, cost):
        if time.monotonic() >= self._next or done == total:
            self._next = time.monotonic() + 1.0
            print(f'\rsearch {done}/{total}: expected torque std {np.sqrt(cost):.3f} x noise',
                  end='\n' if done == total else '', file=sys.stderr, flush=True)


def _per_joint(values):
    return ' '.join(f'{v:.3g}' for v in values)


def _expected(information, trajectory):
    """Print what the motion will tell of the torque of later motions at full speed."""
    samples = trajectory.sample(np.arange(0.0, trajectory.end, 1.0 / information.rate))
    whole, links = information.torque_std(*samples)
    print(f'expected with errors of {_per_joint(information.noise)} Nm, {INDEPENDENT_RATE:g} '
          f'independent ones a second, for {information.base_parameters} base parameters:')
    print(f'  std of predicted torque [Nm]: {_per_joint(whole)}')
    print(f'  by the links alone [Nm]: {_per_joint(links)} (friction and offset take up a part)')
    for name, std in information.friction_std(*samples).items():
        unit = 'Nm' if name == 'coulomb' else 'Nm s/rad'
        print(f'  std of {name} friction [{unit}]: {_per_joint(std)}')


def _report(robot, information, trajectory, clearance):
    print(f'joints: {", ".join(robot.joints)}')
    print(f'centre [rad]: {_per_joint(trajectory.position[0])}')
    print('range [rad]: ' + '  '.join(
        f'{low:.2f}..{high:.2f}' for low, high in zip(trajectory.position.min(axis=0),
                                                      trajectory.position.max(axis=0))))
    print(f'peak speed [rad/s]: {_per_joint(np.abs(trajectory.velocity).max(axis=0))}')
    print('peak acceleration [rad/s^2]: '
          f'{_per_joint(np.abs(trajectory.acceleration).max(axis=0))}')
    allowed = robot.limits.allowed_torque * robot.limits.torque
    use = torque_use(robot, trajectory.position, trajectory.velocity, trajectory.acceleration,
                     allowed)
    print(f'torque without load: {use:.0%} of the allowed at most')
    _expected(information, trajectory)
    if clearance > 0.0:
        print(f'joint origins and load frame stay {clearance:.2f} m from mounting plane '
              'and base column')
    else:
        print('WARNING: the motion goes below the mounting plane or through the base column; '
              'choose another --centre or a smaller --reach')
    print('Collisions are not checked. Move to the centre, run it with a small --speed first, '
          'and watch: it is the same path.')


def _centre(robot, args):
    """Return the centre (n,) that is given, or else a chosen one; refuse an unusable one."""
    if args.centre:
        centre = _numbers(args.centre, '--centre', robot)
        check_centre(robot, centre)
    else:
        centre = choose_centre(robot, args.reach, np.random.default_rng(args.seed))
        check_chosen_centre(robot, centre)
    return centre


def run(args):
    """Search, write the motion in both forms, say what to expect of it."""
    robot = load_robot(find_shared(args.robot, 'robots'))
    _within('--duration', args.duration, 10.0, 600.0)
    _within('--speed', args.speed, 0.05, 1.0)
    _within('--reach', args.reach, 0.05, 3.2)
    csv_path, message_path = _outputs(args.out)
    noise = (_numbers(args.noise, '--noise', robot) if args.noise
             else _DEFAULT_NOISE * robot.limits.torque)
    if np.any(noise <= 0.0):
        raise ConfigurationError('--noise', 'is not usable', args.noise, 'above 0 [Nm]')
    centre = _centre(robot, args)
    # Searched at full speed, whatever --speed: what was watched slowly must be what runs fast.
    search = Search(robot, make_box(robot, centre, args.reach), args.duration, noise, args.seed)
    motion = search.run(_Progress())
    trajectory = search.trajectory(motion).at_speed(args.speed)
    write_trajectory_csv(csv_path, robot.joints, trajectory)
    write_trajectory_message(message_path, robot.joints, trajectory)
    _report(robot, search.information, trajectory, motion.clearance)
    print(f'written: {csv_path} and {message_path} ({trajectory.duration:.1f} s)')
    return 0
