"""`hand_load benchmark`: accuracy beside rivals on simulated arms training never saw."""

from ..errors import ConfigurationError

EXAMPLE = 'hand_load benchmark --out out/benchmark'


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder of the results; what is there already is kept')
    parser.add_argument('--suite', default='base', metavar='NAME',
                        help='base (25 plants x 8 cases), development (the same on other seeds) '
                             'or effects (diagnosis of undeclared effects; hours)')
    parser.add_argument('--robot', default='ur10e', metavar='R.yaml',
                        help='robot file (default: ur10e)')
    parser.add_argument('--learned', default=None, metavar='DIR',
                        help='learned artefact (default: the shipped one); not for effects')


def run(args):
    """Measure and print the page."""
    from ..benchmark.effect_run import run_effects, SUITE
    from ..benchmark.run import run_suite
    command = f'hand_load benchmark --suite {args.suite} --robot {args.robot} --out {args.out}'

    def write(text):
        print(text, flush=True)

    if args.suite == SUITE:
        if args.learned is not None:
            raise ConfigurationError('--learned', 'does not go with the suite', args.learned,
                                     'nothing: effects are judged with method bayes')
        print(run_effects(args.robot, args.out, command, write))
    else:
        print(run_suite(args.suite, args.robot, args.learned, args.out, command, write))
    return 0
