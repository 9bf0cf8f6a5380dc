"""Arguments shared by the commands that read recordings."""

from ..recording_topics import JOINT_STATES, NO_TEMPERATURES, TEMPERATURES
from ..stream.dynamic_joint_states import DYNAMIC_JOINT_STATES


def add_recording_arguments(parser):
    """Add --joint-states and --temperatures."""
    parser.add_argument('--joint-states', metavar='TOPIC', default=JOINT_STATES,
                        help='topic of the joint states (default: %(default)s)')
    parser.add_argument('--temperatures', metavar='TOPIC', default=TEMPERATURES,
                        help='topic of the joint temperatures, or '
                             f'{NO_TEMPERATURES} (default: {TEMPERATURES} and '
                             f'{DYNAMIC_JOINT_STATES}, beside the joint states)')


def topics(args):
    """Return the keyword arguments of read_recording that the command line gave."""
    return {'joint_states': args.joint_states, 'temperatures': args.temperatures}
