"""Run every method on every case of one plant; one JSON per plant, so that a kill costs little."""

from dataclasses import replace
import json
import os
from pathlib import Path
import time

import numpy as np

from ..estimators.bayes import Bayes
from ..estimators.build import build_method
from ..identification import identify, nominal_model
from ..plant import Plant
from ..robot import load_robot
from ..torque_model import ModelFollower
from .bound import Bound
from .cases import case_samples, draw_case, identification_evidence, motion_start
from .rivals import COULOMB_VISCOUS, FixedLoad, LeastSquares

TIMES = (0.1, 0.2, 0.5, 1.0, 3.0, 10.0)   # [s] after motion start; the end of the run follows
MOMENTS = tuple(f'{t:g} s' for t in TIMES) + ('end',)
RATE = 500.0                              # [Hz] of the simulated joint states


class Contestant:
    """
    A method with the torque model it looks through.

    blind: temperatures are withheld from both. seconds: time spent so far.
    """

    def __init__(self, model, method, blind=False):
        self._follower = ModelFollower(model) if model is not None else None
        self._blind, self.seconds = blind, 0.0
        self.method = method(self._follower)

    def update(self, sample):
        """Take one MotionSample; return the Belief."""
        began = time.perf_counter()
        if self._blind:
            sample = replace(sample, temperature=np.full_like(sample.temperature, np.nan))
        prediction = self._follower.update(sample) if self._follower else None
        belief = self.method.update(sample, prediction)
        if self._follower:
            self._follower.carry(belief, self.method)
        self.seconds += time.perf_counter() - began
        return belief


def contestants(robot, models, learned):
    """Return {name: Contestant}, fresh for one case."""
    ours, textbook, nominal = models['ours'], models['textbook'], models['nominal']

    def lstm(follower):
        return build_method(ours, follower.uncertainties, 'lstm', learned)

    return {
        'lstm': Contestant(ours, lstm),
        'bayes': Contestant(ours, lambda f: Bayes(ours, f.uncertainties)),
        'lstm, temperatures withheld': Contestant(ours, lstm, blind=True),
        'least squares, Coulomb + viscous': Contestant(
            textbook, lambda f: LeastSquares(textbook, skip_standing=False)),
        'the same, standing joints left out': Contestant(
            textbook, lambda f: LeastSquares(textbook, skip_standing=True)),
        'recursive least squares, nominal model': Contestant(
            nominal, lambda f: LeastSquares(nominal, skip_standing=False)),
        'fixed rated load': Contestant(None, lambda f: FixedLoad(robot))}


def plant_models(robot, plant, effects=()):
    """Return the models of one plant: ours, the textbook one, the nominal one."""
    evidence = identification_evidence(robot, plant, effects)
    noise = Plant(robot, seed=plant).noise
    return {'ours': identify(robot, evidence),
            'textbook': identify(robot, evidence, COULOMB_VISCOUS),
            'nominal': nominal_model(robot, noise ** 2 / RATE)}


def run_case(robot, case, models, learned, effects=()):
    """Return the plain result of one case: errors and stds of every method at every time."""
    samples = case_samples(robot, case, effects)
    start = motion_start(robot, samples)
    bound = Bound(robot, case.load, Plant(robot, seed=case.plant).noise, RATE)
    methods = contestants(robot, models, learned)
    rows = {name: [] for name in methods}
    bounds, due = [], list(TIMES)

    def note(beliefs):
        bounds.append(bound.std().tolist())
        for name, belief in beliefs.items():
            rows[name].append([belief.mean.tolist(),
                               np.sqrt(np.diag(belief.covariance)).tolist()])

    for sample in samples:
        bound.update(sample)
        beliefs = {name: contestant.update(sample) for name, contestant in methods.items()}
        while start is not None and due and sample.stamp >= start + due[0] - 1e-9:
            due.pop(0)
            note(beliefs)
    note(beliefs)
    return {'plant': case.plant, 'seed': case.seed, 'load': case.load.to_message().tolist(),
            'temperature': case.temperature, 'speed': case.speed, 'bound': bounds,
            'changes': methods['lstm'].method.changes, 'methods': rows,
            'seconds_per_sample': {name: contestant.seconds / len(samples)
                                   for name, contestant in methods.items()}}


def measure_plant(robot_path, plant, case_seeds, learned, folder):
    """Write folder/plant_<seed>.json with all cases of one plant unless it is there; return it."""
    path = Path(folder) / f'plant_{plant}.json'
    if path.exists():
        return path
    robot = load_robot(robot_path)
    models = plant_models(robot, plant)
    results = [run_case(robot, draw_case(robot, plant, seed), models, learned)
               for seed in case_seeds]
    part = path.with_suffix('.part')
    part.write_text(json.dumps(results), encoding='utf-8')
    os.replace(part, path)
    return path
