"""`hand_load learn-gp`: what a torque model leaves without load, learned for methods gp_..."""

import sys

from .identify import read_evidence
from .recording_arguments import add_recording_arguments

EXAMPLE = 'hand_load learn-gp run1 run2 --model model.yaml --out learned/my_arm_gp'


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('recordings', nargs='+', metavar='BAG',
                        help='rosbag2 recordings without load or with a known one')
    parser.add_argument('--model', required=True, metavar='MODEL.yaml',
                        help='torque model whose residual is learned')
    parser.add_argument('--out', required=True, metavar='DIR', help='folder of the artefact')
    parser.add_argument('--function', default='gp', metavar='NAME',
                        help='gp, neural_process, distilled or bayesian_network (default: gp)')
    parser.add_argument('--inputs', default='velocity,temperature', metavar='a,b,...',
                        help="of a joint's position, velocity, acceleration, temperature, and "
                        'pose, the positions of all joints (default: %(default)s)')
    parser.add_argument('--load', metavar='none|L.yaml', default=None,
                        help='load in all recordings; without it each load.yaml says')
    add_recording_arguments(parser)


def run(args):
    """Learn, write the artefact, say how much of it counts and what it takes off the residual."""
    from ..learning.difference_artefact import CARD, SCHEMA
    from ..learning.difference_inputs import parse_inputs
    from ..learning.learn_difference import learn_difference
    from ..torque.model_file import read_model
    from ..files.output_file import output_folder
    from ..files.shared_files import find_shared
    names = parse_inputs(args.inputs)
    model_path = find_shared(args.model, 'models')
    out = output_folder(args.out, {CARD: SCHEMA}, (*args.recordings, model_path, args.load))
    model = read_model(model_path)
    evidence = read_evidence(model.robot, args)
    result = learn_difference(out, model, evidence, args.function, names,
                              write=lambda text: print(text, file=sys.stderr, flush=True))
    print(f'artefact in {out}')
    print('on recordings left out: what is to be subtracted of the learned torque [share],')
    print('and the low-frequency residual with it over without it:')
    for name, gain, share in zip(model.robot.joints, result.gain, result.share):
        print(f'{name:24s} {gain:5.2f} {share:5.2f}')
    return 0
