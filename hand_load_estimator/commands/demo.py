"""`hand_load demo`: the whole loop with a live table and a picture at the end."""

import signal
import sys
import tempfile
from pathlib import Path

import numpy as np

from ..errors import ConfigurationError
from ..estimators.registry import DEFAULT, METHODS
from ..files.output_file import output_file, output_folder
from ..files.shared_files import find_shared
from ..number_argument import number
from ..report.demo_figure import draw_demo
from ..robot import load_robot
from ..simulation.demo import Demo, DemoSettings, draw_load, NodeProcesses
from ..simulation.demo_table import LiveTable
from ..simulation.own_domain import own_domain

EXAMPLE = """
hand_load demo
hand_load demo --seed 4 --temperature 40 --out demo.png
"""
# In every picture that matplotlib writes, of whatever format.
_PICTURE = 'Matplotlib'


def add_arguments(parser):
    """Add the arguments of demo."""
    parser.add_argument('--robot', default='ur10e', metavar='R.yaml',
                        help='robot file, or the short name of a shipped one')
    parser.add_argument('--method', default=DEFAULT, choices=tuple(METHODS),
                        help='estimator (default: %(default)s)')
    parser.add_argument('--seed', type=number(0, 2 ** 31, int), default=1, metavar='N',
                        help='draws the load (default: %(default)s)')
    parser.add_argument('--temperature', type=float, default=25.0, metavar='C',
                        help='of the joints at the start [degC] (default: %(default)s)')
    parser.add_argument('--out', default='out/demo.png', metavar='PNG',
                        help='the picture (default: %(default)s)')


def _summary(carried):
    """Return lines: the estimate while carrying beside the truth."""
    mean, truth, std = carried.mean, carried.truth, np.sqrt(np.maximum(carried.variance, 0.0))
    rows = [('mass [kg]', 0, 1.0)] + [(f'centre {a} [mm]', k, 1e3) for k, a in enumerate('xyz', 1)]
    lines = [f'before the load was put down ({carried.status}, {carried.method}):',
             f'{"":<14}{"estimate":>10}{"2 sigma":>10}{"truth":>10}{"error":>10}']
    for name, k, scale in rows:
        lines.append(f'{name:<14}{scale * mean[k]:>10.3f}{2.0 * scale * std[k]:>10.3f}'
                     f'{scale * truth[k]:>10.3f}{scale * (mean[k] - truth[k]):>10.3f}')
    return lines


def run(args):
    """Run the demo by itself; return 0 when the cycle came to its end."""
    with own_domain():
        return _run(args)


def _run(args):
    try:
        from ..nodes.demo_observer import DemoObserver
    except ImportError as error:
        raise ConfigurationError('demo', f'needs ROS 2 ({error})',
                                 todo='use scripts/demo, or source a ROS 2 Jazzy') from None
    # The nodes must not outlive the demo, however it is ended.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    robot = load_robot(find_shared(args.robot, 'robots'))
    load = draw_load(args.seed, robot.rated_load)
    output_folder(Path(args.out).parent).mkdir(parents=True, exist_ok=True)
    picture = output_file(args.out, _PICTURE)
    logs = Path(tempfile.mkdtemp(prefix='hand_load_demo_'))
    settings = DemoSettings(args.robot, args.method, args.temperature, logs)
    print(f'simulator, estimator and controller start; their logs are in {logs}', flush=True)
    with DemoObserver() as observer, NodeProcesses(settings, load) as processes:
        demo = Demo(observer, processes, LiveTable())
        try:
            demo.run()
        finally:
            # A run that went wrong is worth looking at most.
            _draw(picture, observer, f'{robot.name}, load {args.seed}')
    print('\n'.join(_summary(demo.carried)))
    return 0


def _draw(picture, observer, title):
    if not observer.series['load'] or not observer.series['truth']:
        return
    status = observer.last('status')
    method = status[1].get('method', '') if status else ''
    draw_demo(picture, observer.series, observer.joints, f'{title}, {method}')
    print(f'picture: {picture}')
