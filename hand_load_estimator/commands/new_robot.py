"""`hand_load new-robot`: a robot file to complete, from a URDF."""

from ..files.output_file import output_file
from ..files.robot_draft import draft_robot_file, read_chain, TO_COMPLETE, values_to_complete

EXAMPLE = """
hand_load new-robot my_arm.urdf --out my_arm.yaml
hand_load new-robot my_arm.urdf --out my_arm.yaml --tip tool0
"""


def add_arguments(parser):
    """Add the arguments of new-robot."""
    parser.add_argument('urdf', metavar='URDF', help='URDF of the arm (expand a xacro first)')
    parser.add_argument('--out', metavar='R.yaml', required=True, help='robot file to write')
    parser.add_argument('--tip', metavar='FRAME',
                        help='link at the end of the chain, becomes load_frame '
                             '(default: tool0 or flange where there is one, else the '
                             'farthest that is no finger\'s)')


def run(args):
    """Write the draft and say what is left to do."""
    out = output_file(args.out)
    chain = read_chain(args.urdf, args.tip)
    out.write_text(draft_robot_file(chain, args.urdf, out), encoding='utf-8')
    print(f'{out}: {len(chain.joints)} joints from {chain.base} to {chain.tip}: '
          f'{", ".join(joint.name for joint in chain.joints)}')
    print(f'frames fixed to the last joint: {", ".join(chain.frames)}')
    if chain.beyond and args.tip is None:
        print(f'left out as a gripper behind {chain.tip}: {", ".join(chain.beyond)}; if they are '
              'of the arm, give the link behind them with --tip')
    if chain.massless:
        print(f'links without mass in the URDF: {", ".join(chain.massless)}; the torque model '
              'then has to learn them from recordings alone')
    print(f'to complete, marked {TO_COMPLETE}: {", ".join(values_to_complete(chain))}')
    print('then: `hand_load check RECORDING --robot ' + str(out) + '`')
    return 0
