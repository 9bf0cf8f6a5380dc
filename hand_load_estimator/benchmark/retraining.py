"""The retraining suite: what becomes of the default's artefact under a better torque model."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import ConfigurationError
from ..estimators.build import shipped_artefact
from ..learning.artefact import CARD, read_artefact
from ..learning.training import FINE_TUNING, Recipe, train
from ..residual.diagnosis import CONFIRMED, UNKNOWN
from ..robot import load_robot
from ..torque.model_file import write_model
from .cases import Case, case_run, draw_case
from .contestants import DEFAULT, our_contestants, WITHOUT_NETWORK
from .effect_cases import EffectCase, Hidden, load_seeds, place, SINGLE
from .effect_measure import diagnosis_of, prepared
from .measure import MOMENTS, TIMES
from .scores import LEAST_MASS_FOR_COM, NORMAL_95

# Effects that happen to an arm after its identification, each on a plant of its own, and tried on
# joints in this order: one that motion averages out, one that every load scales.
_JOINTS = (1, 2, 0)
HIDDEN = (Hidden('torque_ripple', 5.0, _JOINTS), Hidden('load_dependent_friction', 5.0, _JOINTS))
RUNS = 32
OLD, KEPT, WITHOUT = 'as it was, old model', 'as it was', f'none (`{WITHOUT_NETWORK}`)'
FROM_SCRATCH = Recipe()
RECIPES = {'calibrated anew': replace(FINE_TUNING, passes=0), 'fine-tuned': FINE_TUNING,
           'trained anew': FROM_SCRATCH}


def retraining_jobs(robot_path, plants, learned, folder, runs=None):
    """Return {label: arguments of measure_retraining}, one per effect and plant."""
    return {f'{hidden.name}_{plant}': (str(robot_path), EffectCase(SINGLE, plant, (hidden,)),
                                       learned, str(folder), runs or RUNS)
            for hidden, plant in zip(HIDDEN, plants)}


def measure_retraining(robot_path, case, learned, folder, runs, recipes=RECIPES):
    """
    Return how each choice estimates loads on an arm after the diagnosis of one hidden effect.

    case: EffectCase of one effect; learned: folder of the artefact that was there, None for the
    shipped one. {'effect', 'plant', 'joints', 'found': what the diagnosis changed, in words,
    'seconds': {choice: s}, 'loads' (runs, 10), 'rows': {choice: (runs, moments, 2, 10) means and
    stds}}. Artefacts and models are made in `folder`, where a training broken off goes on.
    """
    robot = load_robot(robot_path)
    entries = place(robot, case)
    made = prepared(case, entries, robot_path)
    old = made.arm.model
    diagnosis, better, _ = diagnosis_of(old, made.recordings.evidence, made.recordings.test)
    work = Path(folder) / case.label
    work.mkdir(parents=True, exist_ok=True)
    write_model(work / 'better.yaml', better)
    shipped = learned or shipped_artefact(robot)
    seconds = {choice: _trained(work, choice, recipe, shipped, robot)
               for choice, recipe in recipes.items()}
    racing = {OLD: (old, DEFAULT, shipped), KEPT: (better, DEFAULT, shipped),
              **{choice: (better, DEFAULT, str(work / choice)) for choice in recipes},
              WITHOUT: (better, WITHOUT_NETWORK, None)}
    loads, rows = _judged(robot, case.plant, runs, entries, racing)
    return {'effect': case.hidden[0].name, 'plant': case.plant, 'joints': entries[0]['joints'],
            'found': _found(diagnosis), 'seconds': seconds, 'loads': loads, 'rows': rows}


def _found(diagnosis):
    """Return in words what a Diagnosis has put into the model."""
    told = [f'{f.name} on {", ".join(f.joints)}' for f in diagnosis.findings
            if f.verdict == CONFIRMED and f.name != UNKNOWN and not f.recording]
    return '; '.join(told) or 'nothing'


def _judged(robot, plant, runs, entries, racing):
    """Return loads (runs, 10) and {choice: (runs, moments, 2, 10)}, as measure_retraining."""
    cases = [_case(robot, plant, seed, entries) for seed in load_seeds(plant, runs)]
    answers = [(case.load.to_message().tolist(), _answers(robot, case, racing)) for case in cases]
    answers = [(load, answer) for load, answer in answers if answer]
    if not answers:
        raise ConfigurationError('--cases', 'leaves no run in which the arm moves long enough',
                                 runs, todo='ask for more')
    return ([load for load, _ in answers],
            {choice: [answer[choice] for _, answer in answers] for choice in racing})


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
    run = case_run(robot, case)
    if run.start is None or run.samples[-1].stamp < run.start + TIMES[-1]:
        return None
    return {choice: _rows(next(iter(our_contestants(model, (method,), learned).values())),
                          run.samples, run.start)
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
    kept = ('effect', 'plant', 'joints', 'found', 'seconds')
    return {'cases': [{**{key: r[key] for key in kept}, 'runs': len(r['loads']),
                       'choices': {choice: _figures(np.array(r['loads']), np.array(rows))
                                   for choice, rows in r['rows'].items()}}
                      for r in found.values()]}


def _figures(loads, rows):
    error, std = rows[:, :, 0] - loads[:, None], rows[:, :, 1]
    heavy = loads[:, 0] >= LEAST_MASS_FOR_COM
    com = np.linalg.norm(error[heavy][:, :, 1:4], axis=2)
    inside = np.abs(error) <= NORMAL_95 * std
    half_width = NORMAL_95 * np.median(std[..., 0], axis=0)
    return {'mass': dict(zip(MOMENTS, np.sqrt(np.mean(error[:, :, 0] ** 2, axis=0)).tolist())),
            'com': dict(zip(MOMENTS, np.median(com, axis=0).tolist())),
            'half_width': dict(zip(MOMENTS, half_width.tolist())),
            'coverage': float(inside.mean())}
