"""`hand_load calibrate`: make the intervals of a method without a network true."""

from pathlib import Path

EXAMPLE = 'hand_load calibrate --method bayes --model model.yaml --out learned/my_arm_bayes'


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('--method', required=True, metavar='NAME',
                        help='bayes, least_squares or one of gp_...; networks are calibrated when '
                        'they are trained')
    parser.add_argument('--model', required=True, metavar='MODEL.yaml',
                        help='torque model around which arms are drawn')
    parser.add_argument('--learned', default=None, metavar='DIR',
                        help='torque difference of a gp_... method (default: the shipped one of '
                        'the model)')
    parser.add_argument('--out', required=True, metavar='DIR', help='folder of the intervals')


def run(args):
    """Calibrate; progress goes to standard output."""
    from ..files.shared_files import find_shared
    from ..learning.artefact import artefact_folder
    from ..learning.calibrate_method import calibrate_method, CalibrationRecipe
    from ..learning.intervals import kind_of
    model = find_shared(args.model, 'models')
    learned = args.learned and str(find_shared(args.learned, 'learned'))
    artefact_folder(args.out, kind_of(args.method), (model, learned))

    def write(text):
        print(text, flush=True)

    scores = calibrate_method(model, args.out, CalibrationRecipe(args.method, learned), write)
    print(f'intervals in {Path(args.out)}')
    for name, values in scores.items():
        print(f'  {name}: ' + ', '.join(f'{k} {v}' for k, v in values.items()))
    return 0
