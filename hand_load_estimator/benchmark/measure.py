"""Run every method on every case of one plant."""

import atexit
from functools import lru_cache
from pathlib import Path
import shutil
import tempfile

import numpy as np

from ..estimators.build import determined_std
from ..identification.identify import identify, nominal_model
from ..learning.learn_difference import learn_difference
from ..load import LoadParameters
from ..plant import Plant
from ..robot import load_robot
from .bound import Bound
from .cases import identification_evidence, Recorded, untold
from .contestants import (chosen_methods, contestants, cost_of, DEFAULT, functions_of, KNOWN_LOAD,
                          REGRESSOR, RegressorClock)
from .friction_start import case_run_and_start
from .offline import offline_beliefs
from .oracle import added_torque, oracle_of
from .rivals import textbook_model
from .suites import SUITES

TIMES = (0.1, 0.2, 0.5, 1.0, 3.0, 10.0)   # [s] after motion start; the end of the run follows
MOMENTS = tuple(f'{t:g} s' for t in TIMES) + ('end',)
RATE = 500.0                              # [Hz] of the simulated joint states


def plant_models(robot, plant, functions=(), folder=None, recorded=Recorded()):
    """
    Return the models of one plant: ours, the textbook one, the nominal one.

    functions: names of PREDICTORS that learn, each into a folder of its own below `folder`, what
    ours leaves without load, and KNOWN_LOAD for what it leaves with half of the rated load;
    {function: folder} is the entry `difference`.
    """
    evidence = identification_evidence(robot, plant, recorded=recorded)
    noise = Plant(robot, seed=plant).noise
    models = {'ours': identify(robot, evidence),
              'textbook': textbook_model(robot, evidence),
              'nominal': nominal_model(robot, noise ** 2 / RATE)}
    if functions:
        models['difference'] = {name: learn_function(
            name, folder, models['ours'], evidence if name != KNOWN_LOAD else
            identification_evidence(robot, plant, _half(robot.rated_load), recorded))
            for name in functions}
    return models


def learn_function(name, folder, model, evidence):
    """Learn one of functions_of, of what a TorqueModel leaves; return its folder in `folder`."""
    own = Path(folder) / name
    learn_difference(own, model, evidence, 'gp' if name == KNOWN_LOAD else name)
    return own


def _half(load):
    return LoadParameters(0.5 * load.mass, load.com, 0.5 * load.inertia)


# Suites share plants: one process often meets the same plant again.
@lru_cache(maxsize=2)
def robot_and_models(robot_path, plant, functions, recorded=Recorded()):
    """Return the Robot of a file and the plant_models of one plant seed."""
    robot = load_robot(robot_path)
    folder = tempfile.mkdtemp(prefix='hand_load_')
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return robot, plant_models(robot, plant, functions, folder, recorded)


def run_case(robot, case, models, learned=None, methods=None, rivals=(), told=True):
    """
    Return the plain result of one case: errors and stds of every method at every time.

    methods: names of ours (None: all); rivals: names of offline ones; told: whether temperatures
    are known.
    """
    run, friction = case_run_and_start(robot, case)
    added = added_torque(robot, case) if case.hidden else None
    samples = run.samples if told else [untold(sample) for sample in run.samples]
    start = run.start
    bound = Bound(robot, case.load, Plant(robot, seed=case.plant).noise, RATE, friction.std)
    racing = contestants(robot, models, chosen_methods(methods), learned, told)
    clock, rows = RegressorClock(robot), {name: [] for name in racing}
    bounds, start_unknown, noted, due = [], [], [], list(TIMES)

    def note(beliefs):
        """Add the bounds and {name: Belief} of now, of the last sample, to the rows."""
        noted.append(sample.stamp)
        bounds.append(bound.std().tolist())
        start_unknown.append(bound.std_start_unknown().tolist())
        for name, belief in beliefs.items():
            rows[name].append([belief.mean.tolist(),
                               np.sqrt(np.diag(belief.covariance)).tolist()])

    for sample, left in zip(samples, friction.left, strict=True):
        bound.update(sample, left)
        clock.update(sample)
        beliefs = {name: contestant.update(sample) for name, contestant in racing.items()}
        while start is not None and due and sample.stamp >= start + due[0] - 1e-9:
            due.pop(0)
            note(beliefs)
    note(beliefs)
    changes = {name: getattr(c.method, 'changes', 0) for name, c in racing.items()}
    return {'plant': case.plant, 'seed': case.seed, 'load': case.load.to_message().tolist(),
            'temperature': case.temperature, 'speed': case.speed,
            'hidden': [entry['name'] for entry in case.hidden], 'bound': bounds,
            'bound_start_unknown': start_unknown,
            'oracle': added and oracle_of(robot, case.load, models['ours'], added, noted),
            'changes': changes.get(DEFAULT, max(changes.values())),
            'changes_of': changes, 'methods': rows,
            'determined_below': np.repeat(determined_std(robot), (1, 3, 6)).tolist(),
            'mismatch': {name: c.mismatches / len(samples) for name, c in racing.items()},
            'offline': offline_beliefs(rivals, robot, models['textbook'], samples, start),
            'cost': {REGRESSOR: cost_of(clock.times),
                     **{name: cost_of(c.times) for name, c in racing.items()}},
            'seconds_per_sample': {name: float(np.mean(c.times)) for name, c in racing.items()}}


def measure_plant(suite, robot_path, plant, case_seeds, learned, methods, rivals):
    """
    Return the results of all cases of one plant of a suite.

    Offline rivals take part in the plant's first case only: they are slow and do not learn.
    """
    own = SUITES[suite]
    robot, models = robot_and_models(robot_path, plant, functions_of(methods), own.recorded)
    return [run_case(robot, own.draw(robot, plant, seed), models, learned, methods,
                     rivals if k == 0 else (), own.recorded.told)
            for k, seed in enumerate(case_seeds)]
