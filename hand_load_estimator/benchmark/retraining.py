"""The retraining suite: what becomes of the default's artefact when the torque model gets better."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..estimators.build import shipped_artefact
from ..learning.artefact import CARD, read_artefact
from ..learning.training import FINE_TUNING, Recipe, train
from ..model_file import write_model
from ..robot import load_robot
from .cases import Case, case_samples, draw_case, motion_start
from .contestants import DEFAULT, our_contestants, WITHOUT_NETWORK
from .effect_cases import EffectCase, Hidden, load_seeds, place, SINGLE
from .effect_measure import diagnosis_of, prepared
from .measure import MOMENTS, TIMES
from .scores import LEAST_MASS_FOR_COM, NORMAL_95

# Effects that happen to an arm after its identification, each on a plant of its own, and tried on
# joints in this order: one that motion averages out, one that every load scales.
HIDDEN = (('torque_ripple', 5.0), ('load_dependent_friction', 5.0))
JOINTS = (1, 2, 0)
RUNS = 32
OLD, KEPT = 'old model, artefact as it was', 'as it was'
FROM_SCRATCH = Recipe()
RECIPES = {'calibrated anew': replace(FINE_TUNING, passes=0), 'fine-tuned': FINE_TUNING,
           'trained anew': FROM_SCRATCH}


def retraining_jobs(robot_path, plants, learned, folder, runs=None):
    """Return {label: arguments of measure_retraining}, one per effect and plant."""
    return {f'{name}_{plant}': (str(robot_path), plant, name, strength, learned, str(folder),
                                runs or RUNS)
            for (name, strength), plant in zip(HIDDEN, plants)}


def measure_retraining(robot_path, plant, name, strength, learned, folder, runs, recipes=RECIPES):
    """
    Return how each choice estimates loads on an arm after the diagnosis of one hidden effect.

    {'effect', 'plant', 'joints', 'seconds': {choice: s}, 'loads' (runs, 10), 'rows': {choice:
    (runs, moments, 2, 10) means and stds}}. Artefacts and models are made in `folder`, where a
    training broken off goes on.
    """
    robot = load_robot(robot_path)
    case = EffectCase(SINGLE, plant, (Hidden(name, strength, JOINTS),))
    entries = place(robot, case)
    arm, recordings = prepared(case, entries, robot_path)
    _, better, _ = diagnosis_of(arm.model, recordings.evidence, recordings.test)
    work = Path(folder) / f'{name}_{plant}'
    work.mkdir(parents=True, exist_ok=True)
    write_model(work / 'better.yaml', better)
    shipped = learned or shipped_artefact(robot)
    seconds = {choice: _trained(work, choice, recipe, shipped, robot)
               for choice, recipe in recipes.items()}
    racing = {OLD: (arm.model, DEFAULT, shipped),
              KEPT: (better, DEFAULT, shipped),
              **{choice: (better, DEFAULT, str(work / choice)) for choice in recipes},
              f'none (`{WITHOUT_NETWORK}`)': (better, WITHOUT_NETWORK, None)}
    cases = [_case(robot, plant, seed, entries) for seed in load_seeds(plant, runs)]
    answers = [_answers(robot, case, racing) for case in cases]
    return {'effect': name, 'plant': plant, 'joints': entries[0]['joints'], 'seconds': seconds,
            'loads': [case.load.to_message().tolist() for case, a in zip(cases, answers) if a],
            'rows': {choice: [a[choice] for a in answers if a] for choice in racing}}


def _trained(work, choice, recipe, shipped, robot):
    """Train a choice into a folder of its name, unless it is there; return what it took [s]."""
    folder = work / choice
    if not (folder / CARD).exists():
        start = None if recipe is FROM_SCRATCH else shipped
        train(work / 'better.yaml', folder, recipe, start_from=start)
    return read_artefact(folder, robot).card['wall_seconds']


def _case(robot, plant, seed, entries):
    drawn = draw_case(robot, plant, seed)
    return Case(plant, seed, drawn.load, drawn.temperature, drawn.speed, hidden=tuple(entries))


def _answers(robot, case, racing):
    """Return {choice: (moments, 2, 10)} of one run, None where the arm moved too briefly."""
    samples = case_samples(robot, case)
    start = motion_start(robot, samples)
    if start is None or samples[-1].stamp < start + TIMES[-1]:
        return None
    return {choice: _rows(next(iter(our_contestants(model, (method,), learned).values())),
                          samples, start)
            for choice, (model, method, learned) in racing.items()}


def _rows(contestant, samples, start):
    rows, due = [], list(TIMES)
    for sample in samples:
        belief = contestant.update(sample)
        while due and sample.stamp >= start + due[0] - 1e-9:
            due.pop(0)
            rows.append(_row(belief))
    return [*rows, _row(belief)]


def _row(belief):
    return [belief.mean.tolist(), np.sqrt(np.diag(belief.covariance)).tolist()]


def retraining_scores(found):
    """
    Return {'cases': [...]} of results by label.

    Per case and choice: mass RMSE [kg], median distance of the centre of mass [m] of heavy loads
    and median half-width of the mass's 95 % interval [kg] at every moment; share of all
    intervals, over parameters and moments, that hold the truth.
    """
    return {'cases': [{**{key: r[key] for key in ('effect', 'plant', 'joints', 'seconds')},
                       'runs': len(r['loads']),
                       'choices': {choice: _figures(np.array(r['loads']), np.array(rows))
                                   for choice, rows in r['rows'].items()}}
                      for r in found.values()]}


def _figures(loads, rows):
    error, std = rows[:, :, 0] - loads[:, None], rows[:, :, 1]
    heavy = loads[:, 0] >= LEAST_MASS_FOR_COM
    com = np.linalg.norm(error[heavy][:, :, 1:4], axis=2)
    inside = np.abs(error) <= NORMAL_95 * std
    return {'mass': dict(zip(MOMENTS, np.sqrt(np.mean(error[:, :, 0] ** 2, axis=0)).tolist())),
            'com': dict(zip(MOMENTS, np.median(com, axis=0).tolist())),
            'half_width': dict(zip(MOMENTS, (NORMAL_95 * np.median(std[..., 0], axis=0)).tolist())),
            'coverage': float(inside.mean())}
