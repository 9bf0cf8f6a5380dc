"""The demo: three nodes as processes, one pick-and-place with a load the estimator must find."""

import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import HandLoadError
from ..files.shared_files import PACKAGE, share_folder
from ..load import LoadParameters
from ..seeds import SHIPPED_MODEL_PLANT

_PERIOD = 0.2  # [s] between two looks at the nodes
_LATE = 60.0  # [s] without a change of phase: something hangs
_AFTER = 2.0  # [s] to show how the estimate follows an emptied hand
# Simulated seconds per second. A collision threshold allows messages 30 ms: at full speed a
# machine of two cores doing other work too is later than that, and the controller stops the arm.
_PACE = 0.7


class DemoError(HandLoadError):
    """A node of the demo ended or hangs."""


def draw_load(seed, rated):
    """Return a random box within reach of a hand; rated: LoadParameters of the robot file."""
    rng = np.random.default_rng([seed, 77])
    mass = rated.mass * rng.uniform(0.15, 0.75)
    sides = rng.uniform(0.05, 0.30, 3)
    inertia = mass / 12.0 * (np.sum(sides**2) * np.eye(3) - np.diag(sides**2))
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    com = rated.com + rng.uniform(-0.06, 0.06, 3)
    return LoadParameters(mass, com, turn @ inertia @ turn.T)


@dataclass(frozen=True)
class DemoSettings:
    """
    What the demo runs.

    robot, method: as the nodes' parameters; temperature [degC] of the joints at the start;
    folder: where logs go. The arm is the one the shipped torque model was identified from.
    """

    robot: str
    method: str
    temperature: float
    folder: Path


def _parameters(settings, load):
    """Return node -> parameters."""
    vector = [float(value) for value in load.to_message()]
    return {
        'simulator': {'robot': settings.robot, 'plant_seed': SHIPPED_MODEL_PLANT,
                      'start_temperature': settings.temperature, 'real_time_factor': _PACE,
                      'load.mass': vector[0], 'load.com': vector[1:4],
                      'load.inertia': vector[4:]},
        'estimator': {'robot': settings.robot, 'method': settings.method,
                      'use_sim_time': True},
        'controller': {'robot': settings.robot, 'autostart': True, 'use_sim_time': True},
    }


class NodeProcesses:
    """The three nodes as processes, each with a log file; ended on leaving the context."""

    def __init__(self, settings, load):
        self._folder, self._processes = settings.folder, {}
        self._folder.mkdir(parents=True, exist_ok=True)
        for name, parameters in _parameters(settings, load).items():
            arguments = [part for key, value in parameters.items()
                         for part in ('-p', f'{key}:={_yaml(value)}')]
            with open(self.log(name), 'wb') as log:
                self._processes[name] = subprocess.Popen(
                    [sys.executable, '-m', f'{PACKAGE}.nodes.{name}_node', '--ros-args',
                     '--params-file', str(share_folder() / 'config' / f'{name}.yaml'),
                     *arguments],
                    stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                    start_new_session=True,
                    env={**os.environ, 'PYTHONUNBUFFERED': '1'})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self._processes.values():
            if process.poll() is None:
                process.terminate()
        for process in self._processes.values():
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def log(self, name):
        """Return the path of a node's log."""
        return self._folder / f'{name}.log'

    def check(self):
        """Raise DemoError when a node has ended."""
        for name, process in self._processes.items():
            if process.poll() is not None:
                lines = self.log(name).read_text(errors='replace').strip().splitlines()
                raise DemoError(f'{name} ended with status {process.returncode}: '
                                f'{lines[-1] if lines else "it said nothing"} '
                                f'(all of it in {self.log(name)})')


def _yaml(value):
    # A text in quotes, so that a robot called 1.5 or an empty one stays a text.
    return f"'{value}'" if isinstance(value, str) else str(value).lower()


@dataclass(frozen=True)
class Carried:
    """The end of the way with the load: mean, variance, truth (10,) in message order; status."""

    mean: np.ndarray
    variance: np.ndarray
    truth: np.ndarray
    status: str
    method: str


class Demo:
    """Follows the controller's phases, closes and opens the hand, keeps what was carried."""

    def __init__(self, observer, processes, table):
        self._observer, self._processes, self._table = observer, processes, table
        self._seen = 0
        self.carried = None

    def run(self):
        """Run to the end of the cycle; raises DemoError when it does not come."""
        changed, ended = time.monotonic(), None
        while ended is None or time.monotonic() - ended < _AFTER:
            self._observer.spin(_PERIOD)
            self._processes.check()
            self._table.show(self._observer)
            if self._observer.refusal:
                raise DemoError(f'the simulator refused: {self._observer.refusal}')
            # All of them, not only the last: a short phase must not be missed.
            for _, phase in self._observer.series['phase'][self._seen:]:
                self._seen, changed = self._seen + 1, time.monotonic()
                self._enter(phase)
                ended = changed if phase == 'done' else ended
            if ended is None and time.monotonic() - changed > _LATE:
                raise DemoError(f'nothing has happened for {_LATE:g} s in phase '
                                f'{self._observer.phase or "before the start"}; '
                                f'see {self._processes.log("controller")}')
        if self.carried is None:
            raise DemoError('nothing was carried')

    def _enter(self, phase):
        if phase == 'stopped':
            raise DemoError('the controller stopped the arm; see '
                            f'{self._processes.log("controller")}')
        if phase == 'at_pick':
            self._observer.hold(True)
        elif phase == 'at_place':
            self._keep()
            self._observer.hold(False)

    def _keep(self):
        last = [self._observer.last(name) for name in ('load', 'variance', 'truth', 'status')]
        if any(value is None for value in last):
            raise DemoError(f'the estimator has said nothing; see '
                            f'{self._processes.log("estimator")}')
        status, values = last[3]
        self.carried = Carried(*last[:3], status, values.get('method', ''))
