"""The demo's parts that need no nodes: load, table, picture, and what it says of a dead node."""

import io
import re
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread
from ros_helpers import node_environment

from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.report.demo_figure import draw_demo
from hand_load_estimator.robot import load_robot
from hand_load_estimator.simulation.demo import DemoError, DemoSettings, NodeProcesses, draw_load
from hand_load_estimator.simulation.demo_table import LiveTable, plain_line, table_lines

RATED = LoadParameters(10.0, [0.0, 0.0, 0.1], 0.1 * np.eye(3))


class Terminal(io.StringIO):
    """A text stream that says it is a terminal."""

    def isatty(self):
        """Say so."""
        return True


def observed(phase='carrying', mass=2.0):
    """Return what a DemoObserver would have seen last."""
    values = {'load': np.array([mass, 0.01, 0.02, 0.1] + [0.01] * 6),
              'variance': np.array([0.01, 1e-4, 1e-4, 1e-4] + [1e-4] * 6),
              'status': ('ESTIMATING', {'method': 'lstm', 'reason': 'still moving'})}
    return SimpleNamespace(phase=phase, last=values.get, limits=np.full((2, 6), 3.0))


def test_loads_are_possible_bodies_below_the_rated_mass():
    loads = [draw_load(seed, RATED) for seed in range(200)]
    assert all(load.is_physical() for load in loads)
    masses = [load.mass for load in loads]
    assert 1.0 < min(masses) < 2.0 and 7.0 < max(masses) < 8.0
    assert draw_load(3, RATED).mass == draw_load(3, RATED).mass


def test_table_shows_mean_and_two_sigma():
    lines = '\n'.join(table_lines(observed()))
    assert '2.000 ±   0.200 kg' in lines and '100.000 ±  20.000 mm' in lines
    assert 'ESTIMATING (lstm)' in lines and 'accelerate     3.00' in lines
    assert '2.000 ±   0.200 kg' in plain_line(observed())


def test_table_waits_for_what_is_not_there_yet():
    nothing = SimpleNamespace(phase='', last=lambda name: None, limits=None)
    assert 'starting' in '\n'.join(table_lines(nothing)) and 'NO_DATA' in plain_line(nothing)


def test_table_is_redrawn_in_a_terminal_and_a_line_elsewhere():
    terminal, file = Terminal(), io.StringIO()
    for out in (terminal, file):
        table = LiveTable(out)
        for phase in ('home', 'home', 'at_pick'):
            table.show(observed(phase))
    height = len(table_lines(observed()))
    assert terminal.getvalue().count(f'\x1b[{height}A') == 2
    assert '\x1b' not in file.getvalue()
    assert [line.split()[0] for line in file.getvalue().splitlines()] == ['home', 'at_pick']


def test_picture_is_drawn(tmp_path):
    times = np.arange(0.0, 8.0, 0.02)
    mean = np.zeros((len(times), 10))
    mean[:, 0] = np.where(times > 3.0, 2.0 - np.exp(3.0 - times), 0.0)
    series = {
        'load': list(zip(times, mean)),
        'variance': list(zip(times, np.full((len(times), 10), 0.02))),
        'truth': [(0.0, np.zeros(10)), (3.0, np.array([2.0, 0.0, 0.0, 0.1] + [0.0] * 6))],
        'temperature': [(t, (joint, 25.0 + t)) for t in times[::5] for joint in 'ab'],
        'residual': list(zip(times, np.random.default_rng(0).normal(size=(len(times), 2)))),
        'phase': [(0.0, 'home'), (2.5, 'at_pick'), (4.0, 'carrying')]}
    draw_demo(tmp_path / 'demo.png', series, ('a', 'b'), 'a title')
    picture = imread(tmp_path / 'demo.png')
    assert picture.shape[0] > 800 and picture.shape[1] > 800
    assert len(np.unique(picture.reshape(-1, picture.shape[2]), axis=0)) > 50


def test_dead_node_is_told_with_its_last_words(tmp_path):
    settings = DemoSettings('no_such_robot', 'lstm', 25.0, tmp_path)
    with NodeProcesses(settings, draw_load(1, RATED)) as processes:
        end = time.monotonic() + 60.0
        with pytest.raises(DemoError, match='(simulator|estimator|controller) ended with '
                                            'status 2: .*no_such_robot'):
            while time.monotonic() < end:
                processes.check()
                time.sleep(0.05)


def test_demo_ends_by_itself_with_the_load_found_and_a_picture(domain, tmp_path):
    """As scripts/demo starts it, three processes and all."""
    picture = tmp_path / 'new' / 'x.png'
    done = subprocess.run(
        [sys.executable, '-m', 'hand_load_estimator', 'demo', '--out', str(picture)], text=True,
        capture_output=True, timeout=120, cwd=tmp_path, env=node_environment(domain))
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'Traceback' not in done.stderr
    number = r' +(-?[\d.]+)'
    found = re.search(rf'^mass \[kg\]{number}{number}{number}', done.stdout, re.MULTILINE)
    mass, two_sigma, truth = map(float, found.groups())
    assert truth == pytest.approx(draw_load(1, ur10e_rated()).mass, abs=1e-3)
    assert abs(mass - truth) < 2.0 * two_sigma and two_sigma < 0.2, done.stdout
    assert ', lstm):' in done.stdout, 'the default method'
    height, width = imread(picture).shape[:2]
    assert height > 800 and width > 800


def ur10e_rated():
    """Return the rated load of the default robot."""
    return load_robot(find_shared('ur10e', 'robots')).rated_load
