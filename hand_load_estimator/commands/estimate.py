"""`hand_load estimate`: the load in a recording, as the running estimator would have told it."""

import json
import sys

from ..estimators.registry import DEFAULT, METHODS
from .recording_arguments import add_recording_arguments, topics

EXAMPLE = 'hand_load estimate run --model ur10e --out estimate.json'


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('recording', metavar='BAG', help='rosbag2 recording')
    parser.add_argument('--model', required=True, metavar='MODEL.yaml',
                        help='torque model, or the name of a shipped one')
    parser.add_argument('--out', required=True, metavar='FILE.json', help='result to write')
    parser.add_argument('--method', default=DEFAULT, metavar='NAME',
                        help=f'{", ".join(METHODS)} (default: %(default)s; without an artefact '
                             'gp_... ends with a message, the others become bayes)')
    parser.add_argument('--learned', default=None, metavar='DIR',
                        help='learned artefact, or the name of a shipped one (default: the one '
                             'shipped for the robot; for gp_... for the model)')
    parser.add_argument('--intervals', default=None, metavar='DIR',
                        help='calibrated intervals of a method without a network, or the name of '
                             'shipped ones (default: those shipped for this very model, '
                             'else as the method states them)')
    parser.add_argument('--tool', default=None, metavar='T.yaml',
                        help='load file of a known tool, which may state `std`; the answer is '
                             'what is held beside it (default: none)')
    add_recording_arguments(parser)


def run(args):
    """Estimate, write the JSON and print the answer."""
    from ..estimators.estimation import estimate_recording, SCHEMA
    from ..estimators.build import build_pipeline
    from ..files.output_file import output_file
    from ..recording import read_recording
    from ..files.shared_files import find_shared
    model = find_shared(args.model, 'models')
    learned = args.learned and str(find_shared(args.learned, 'learned'))
    intervals = args.intervals and str(find_shared(args.intervals, 'learned'))
    out = output_file(args.out, SCHEMA, (args.recording, model, learned, intervals, args.tool))
    pipeline = build_pipeline(model, args.method, learned, tool_path=args.tool,
                              intervals=intervals)
    # The answer must not know the load: load.yaml is not read.
    recording = read_recording(args.recording, with_load=False, **topics(args))
    result = estimate_recording(pipeline, recording)
    out.write_text(json.dumps(result) + '\n', encoding='utf-8')
    _report(result)
    return 0


def _report(result):
    print(f'{result["status"]} ({result["method"]}, {result["samples"]} samples, '
          f'{sum(result["rejected"].values())} rejected)')
    print(f'intervals: {result["intervals"]}')
    if result['status'] != 'DETERMINED':
        print(result['reason'])
    if result['status'] != 'NO_DATA':
        _report_load(result)
    if result['rejected']:
        print(f'rejected input: {result["rejected"]}', file=sys.stderr)


def _report_load(result):
    mass, com = result['mass'], result['com']
    print(f'mass {mass["mean"]:.3f} +- {1.96 * mass["std"]:.3f} kg (95 %)')
    print('centre of mass [mm] in ' + result['frame'] + ': ' + ', '.join(
        f'{1e3 * m:.1f} +- {1e3 * 1.96 * s:.1f}' for m, s in zip(com['mean'], com['std'])))
