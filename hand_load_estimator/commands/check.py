"""`hand_load check`: is a recording what the robot file says it is."""

import json
import textwrap

from ..checks.finding import WRONG
from ..checks.recording_check import check_recording
from ..files.shared_files import find_shared
from ..recording import read_recording
from ..robot import load_robot
from .recording_arguments import add_recording_arguments

EXAMPLE = """
hand_load check my_recording --robot my_arm.yaml
hand_load check my_recording --robot ur10e --joint-states /left/joint_states --json
"""
_WIDTH = 99
_FOUND_WRONG = 1


def add_arguments(parser):
    """Add the arguments of check, and what its exit status says."""
    parser.description += (' The exit status is 1 where a row says wrong, and 2 where the '
                           'recording cannot be read.')
    parser.add_argument('bag', metavar='BAG', help='folder of a rosbag2 recording')
    parser.add_argument('--robot', metavar='R.yaml', required=True,
                        help='robot file, or the short name of a shipped one')
    add_recording_arguments(parser)
    parser.add_argument('--json', action='store_true', help='print JSON instead of a table')


def _line(finding):
    head = f'{finding.verdict:<11}  {finding.item:<16}  '
    text = finding.text + (f' -> {finding.todo}' if finding.todo else '')
    return textwrap.fill(text, _WIDTH, initial_indent=head, subsequent_indent=' ' * len(head))


def _joint_table(joints):
    width = max(map(len, joints))
    yield f'{"joint":<{width}}  gain            friction [Nm]  r2     unexplained [Nm]'
    for name, row in joints.items():
        gain = (f'{row["gain"]:6.2f} +- {row["gain_std"]:<5.2f}' if row['gain'] is not None
                else 'not told       ')
        yield (f'{name:<{width}}  {gain} {row["friction"]:8.2f}       {row["r2"]:5.3f}  '
               f'{row["residual"]:8.3f}')


def run(args):
    """Print the findings; 1 where one is wrong, else 0."""
    robot = load_robot(find_shared(args.robot, 'robots'))
    check = check_recording(read_recording(args.bag, args.joint_states, args.temperatures), robot)
    if args.json:
        print(json.dumps(check.to_dict(), indent=2))
    else:
        _print(check, robot)
    return _FOUND_WRONG if any(f.verdict == WRONG for f in check.findings) else 0


def _print(check, robot):
    print(f'{check.recording} for {check.robot} ({robot.effort.kind})')
    for finding in check.findings:
        print(_line(finding))
    if check.joints:
        print('\neffort against rigid body and friction (gain: 1 when the robot file is right)')
        print('\n'.join(_joint_table(check.joints)))
