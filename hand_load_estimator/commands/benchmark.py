"""`hand_load benchmark`: accuracy beside rivals on simulated arms training never saw."""

from pathlib import Path

from ..errors import ConfigurationError
from ..files.output_file import output_folder
from ..number_argument import number

EXAMPLE = """
hand_load benchmark --out out/benchmark
hand_load benchmark --out out/all --suite all --rivals mujoco.sysid,figaroh
hand_load benchmark --out out/all --suite base --cases 2000 --methods lstm
hand_load benchmark --out out/look --suite cold,warm --development --cases 4 --methods bayes
"""


def _names(text):
    return tuple(name for name in text.split(',') if name)


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder of the results, one below it for every suite and choice, '
                             'and the table of goals over all that are there; what is there '
                             'already is kept')
    parser.add_argument('--suite', default='base', metavar='NAMES',
                        help='base (25 plants x 8 cases), development (the same on other seeds), '
                             'cold, warm, room (warm, in a cool one), slow, fast, '
                             'sparse (identified from little), '
                             'inertia, undeclared, arms, changes, suggestion (following '
                             'suggested motions), pushes (on the hand), real, cost, soak, '
                             'retraining (the artefact beside a better model), ageing (what '
                             '/diagnostics tells of an aged model), or several of them with '
                             'commas; all (but for these two); or effects (diagnosis of '
                             'undeclared effects; hours)')
    parser.add_argument('--robot', default='ur10e', metavar='R.yaml',
                        help='robot file (default: ur10e)')
    parser.add_argument('--learned', default=None, metavar='DIR',
                        help='learned artefact, or the name of a shipped one (default: the one '
                             'shipped for the robot); not for real and effects')
    parser.add_argument('--cases', default=None, type=number(1, kind=int), metavar='N',
                        help='cases per suite (default: 200 of base, 4 per effect of '
                             'undeclared, all of ageing, 40 of others); from more than its '
                             'own on, an accuracy suite takes 50 plants, on seeds that '
                             'smaller runs never use')
    parser.add_argument('--methods', default=None, type=_names, metavar='A,B',
                        help='methods to measure, and gru_subset (of the ur10e only), '
                             'gp_bayes_neural_process, gp_bayes_distilled, '
                             'gp_bayes_bayesian_network, gp_bayes_known_load '
                             '(default: all); bayes_calibrated and the like state the '
                             'intervals shipped for a method without a network')
    parser.add_argument('--rivals', default=(), type=_names, metavar='A,B',
                        help='offline rivals beside us: mujoco.sysid, figaroh (default: none; '
                             'each needs its package)')
    parser.add_argument('--hours', default=None, type=number(1e-3), metavar='H',
                        help='of running in changes (default: 10) and of soak (default: 24)')
    parser.add_argument('--data', default='../shared/data', metavar='DIR',
                        help='measured recordings of suite real (default: ../shared/data)')
    parser.add_argument('--development', action='store_true',
                        help='on seeds for looking and choosing, not the benchmark\'s')
    parser.add_argument('--workers', default=None, type=number(0, kind=int), metavar='N',
                        help='processes (default: one per core, or all that the backend has); '
                             'soak and retraining are one')
    parser.add_argument('--backend', default='processes', metavar='NAME',
                        help='processes, or a backend of joblib for a cluster (default: '
                             'processes); cost, soak and retraining stay on this machine')


def run(args):
    """Measure and print the page."""
    from ..benchmark.effect_run import run_effects, SUITE
    from ..benchmark.run import Options, run_suites
    from ..files.shared_files import find_shared
    _check_folder(args.out)
    given = _given(args)
    command = ' '.join(['hand_load benchmark', *(
        f'--{name}' if value is True else f'--{name} {value}' for name, value in given.items())])

    def write(text):
        print(text, flush=True)

    if args.suite == SUITE:
        _only_of_others(given)
        print(run_effects(args.robot, args.out, command, write, args.workers, args.development,
                          args.backend))
        return 0
    learned = args.learned and str(find_shared(args.learned, 'learned'))
    options = Options(args.robot, learned, args.cases, args.methods, args.rivals, args.hours,
                      args.data, args.development, args.workers, args.backend)
    print(run_suites(args.suite, options, args.out, command, write))
    return 0


def _check_folder(path):
    """Refuse a folder whose pages are none of a benchmark's, which has its scores beside them."""
    from ..benchmark.run import SCHEMA
    scores = Path(path) / 'scores.json'
    output_folder(path, {scores.name: SCHEMA} if scores.exists()
                  else dict.fromkeys(('README.md', 'index.html')))


# Said in the command line that a page shows only when they differ from this.
_DEFAULTS = (('data', '../shared/data'), ('backend', 'processes'))


def _given(args):
    """Return {option: value} of what is asked for, lists with commas as on the command line."""
    return {name: ','.join(value) if isinstance(value, tuple) else value
            for name, value in vars(args).items()
            if value not in (None, (), False) and (name, value) not in _DEFAULTS}


def _only_of_others(given):
    """Refuse what suite effects does not take, rather than leave it out unsaid."""
    for name in ('learned', 'cases', 'methods', 'rivals', 'hours', 'data'):
        if name in given:
            raise ConfigurationError(f'--{name}', 'does not go with the suite', given[name],
                                     'nothing: effects has its own cases, judged with bayes')
