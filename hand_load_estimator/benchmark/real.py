"""The real suite: on measured recordings without load the estimate must stay near zero."""

from pathlib import Path
import shutil

import numpy as np

from ..errors import ConfigurationError
from ..files.shared_files import find_shared
from ..identification.evidence import prepare
from ..identification.identify import identify, nominal_model
from ..load import LoadParameters
from ..recording import read_recording
from ..robot import load_robot
from ..stream.joint_stream import JointStream, motion_of, motion_samples
from .cases import motion_start
from .contestants import (chosen_methods, Contestant, functions_of, KNOWN_LOAD, NOMINAL,
                          our_contestants, OUR_MODEL, TEXTBOOK, TEXTBOOK_CAREFUL)
from .measure import learn_function
from .offline import offline_beliefs
from .real_course import CourseOf, JUDGED_FROM
from .real_robots import ARMS, write_robot_file
from .real_sets import SETS, stage
from .rivals import LeastSquares, textbook_model

TIMES = (0.5, 1.0, 3.0, 10.0)   # [s] after motion start; the end follows
MOMENTS = tuple(f'{t:g} s' for t in TIMES) + ('end',)
# Runs with a load that the models above are tried on too: {set: {run: mass [kg]}}. By the file's
# name; a fit with the controller's gains says 2.50 kg (README of the data).
LOADED = {'ur10e': {'ident_20_01_13-load_2600': 2.6}}


def real_jobs(data, names, folder, methods, rivals=()):
    """Return {label: arguments} of measure_set; raises ConfigurationError without the data."""
    data = Path(data)
    if not data.is_dir():
        raise ConfigurationError('--data', 'is not there', str(data),
                                 f'the folder that holds {", ".join(SETS)}')
    found = [name for name in names or SETS if (data / name).is_dir()]
    return {f'real_{name}': (name, str(data), str(folder), methods, rivals)
            for name in found}


def measure_set(name, data, folder, methods, rivals=()):
    """
    Return what every method, and offline rivals, say of the test runs of one measured set.

    A list of {'set', 'run', 'truth' (mass [kg] beside what the model was identified with),
    'rated', 'methods': {name: [[mass, std], ...]} at MOMENTS, None where the run is shorter,
    'course': {name: a Course as a dict}, of those that go sample by sample}.
    """
    chosen, data = SETS[name], Path(data)
    inputs = Path(folder) / 'inputs' / name
    shutil.rmtree(inputs, ignore_errors=True)
    train, test = stage(chosen, data / name, inputs)
    path = (write_robot_file(name, data, inputs) if chosen.robot in ARMS
            else find_shared(chosen.robot, 'robots'))
    robot = load_robot(path)
    recordings = [read_recording(run) for run in train]
    evidence = [_evidence(robot, recording) for recording in recordings]
    models = _models(robot, evidence, methods, inputs / 'learned')
    held = (recordings[0].load or LoadParameters()).mass
    runs = [(run, held) for run in test]
    runs += [(data / name / run, mass) for run, mass in LOADED.get(name, {}).items()]
    return [{'set': name, 'run': Path(run).name, 'truth': mass, 'rated': robot.rated_load.mass,
             **_found(robot, models, read_recording(run, with_load=False), methods, mass, rivals)}
            for run, mass in runs]


def _evidence(robot, recording):
    motion, _ = motion_of(robot, recording)
    return prepare(robot, recording.path.name, motion, recording.load or LoadParameters(),
                   recording)


def _models(robot, evidence, methods, folder):
    """Return the models of one set as plant_models does; what is learned lies below `folder`."""
    ours = identify(robot, evidence)
    # All training runs carry one load: KNOWN_LOAD has no others to be learned from.
    functions = [name for name in functions_of(methods) if name != KNOWN_LOAD]
    return {'ours': ours, 'textbook': textbook_model(robot, evidence),
            # How joints are to be weighed, only what the identified model leaves can tell.
            'nominal': nominal_model(robot, ours.residuals.intensity),
            'difference': {name: learn_function(name, folder, ours, evidence)
                           for name in functions}}


def _racing(models, methods):
    ours, textbook, nominal = models['ours'], models['textbook'], models['nominal']
    return {**our_contestants(ours, chosen_methods(methods), None, models['difference']),
            TEXTBOOK: Contestant(textbook, lambda f: LeastSquares(textbook, False)),
            TEXTBOOK_CAREFUL: Contestant(textbook, lambda f: LeastSquares(textbook, True)),
            OUR_MODEL: Contestant(ours, lambda f: LeastSquares(ours, True)),
            NOMINAL: Contestant(nominal, lambda f: LeastSquares(nominal, False))}


def _found(robot, models, recording, methods, truth, rivals):
    """Return 'methods' and 'course' of measure_set for one run; truth: the mass held [kg]."""
    samples = [s for s in motion_samples(JointStream(robot), recording) if not s.fresh]
    start, racing = motion_start(robot, recording.samples), _racing(models, methods)
    out, due = {name: [None] * len(MOMENTS) for name in racing}, list(enumerate(TIMES))
    if start is None:
        return {'methods': out, 'course': {}}
    courses = {name: CourseOf(truth) for name in racing}
    for sample in samples:
        beliefs = {name: c.update(sample) for name, c in racing.items()}
        beliefs = judged(racing, beliefs, truth)
        for name, course in courses.items():
            course.update(beliefs[name], sample.stamp > start + JUDGED_FROM)
        while due and sample.stamp >= start + due[0][1] - 1e-9:
            _note(out, due.pop(0)[0], beliefs)
    _note(out, -1, beliefs)
    told = offline_beliefs(rivals, robot, models['textbook'], samples, start)
    offline = {name: [_offline(found.get(moment), start + t <= sample.stamp)
                      for moment, t in zip(MOMENTS, (*TIMES, 0.0))]
               for name, found in told.items()}
    return {'methods': {**out, **offline},
            'course': {name: course.told(racing[name]) for name, course in courses.items()}}


def _offline(found, lasted):
    """Return [mass, std] of what a rival said; None: failed, not asked, run too short."""
    if not lasted or found is None or isinstance(found, str):
        return None
    return [found[0][0], found[1][0]]


def judged(racing, beliefs, truth):
    """
    Return {name: Belief} to score of Contestants that published `beliefs`.

    Ours publish no mass below zero and rivals do: where zero is the truth, that would halve our
    error for no merit. There it is what methods believe.
    """
    if truth:
        return beliefs
    return {name: c.method.belief() if hasattr(c.method, 'tared') else beliefs[name]
            for name, c in racing.items()}


def _note(out, place, beliefs):
    for name, belief in beliefs.items():
        out[name][place] = [float(belief.mean[0]), float(np.sqrt(belief.covariance[0, 0]))]


def real_scores(results):
    """Return {'runs': [...], 'methods': {name: figures}} of results by label."""
    runs = [run for part in results.values() for run in part]
    # A run in which no joint that carries the load moves has no figures.
    names = {name: None for run in runs for name, found in run['methods'].items() if found[-1]}
    return {'runs': runs, 'methods': {name: _figures(name, runs) for name in names}}


def _figures(name, runs):
    """
    Return the figures of one method over all runs.

    'runs'; of the error at the end its 'median_percent' and 'worst_percent' (of rated),
    'possible_percent', the median where a mass below zero counts as zero, and how often 2 std
    cover it ('inside'); 'percent_at': {moment: median, % of rated}; of the Courses
    'later_percent' (largest |error| of all, % of rated), 'time_inside' and 'mismatch' (shares of
    the time, mean over runs) and 'changes', each None where a method has none.
    """
    ours = [run for run in runs if name in run['methods'] and run['methods'][name][-1]]
    errors, rated = _errors(name, ours, -1), np.array([run['rated'] for run in ours])
    percent = 100.0 * np.abs(errors) / rated
    # No mass is below zero, so no error is below the truth's.
    possible = 100.0 * np.abs(np.maximum(errors, [-run['truth'] for run in ours])) / rated
    inside = np.abs(errors) <= 1.96 * np.array([run['methods'][name][-1][1] for run in ours])
    return {'runs': len(ours), 'median_percent': float(np.median(percent)),
            'worst_percent': float(percent.max()),
            'possible_percent': float(np.median(possible)), 'inside': float(inside.mean()),
            'percent_at': {moment: _median_percent(name, ours, k)
                           for k, moment in enumerate(MOMENTS)},
            **_course_figures([(run['course'][name], run['rated']) for run in ours
                               if name in run['course']])}


def _errors(name, runs, place):
    return np.array([run['methods'][name][place][0] - run['truth'] for run in runs])


def _median_percent(name, runs, place):
    """Return the median |error| at a place of MOMENTS [% of rated], None where none was asked."""
    asked = [run for run in runs if run['methods'][name][place]]
    if not asked:
        return None
    rated = np.array([run['rated'] for run in asked])
    return float(np.median(100.0 * np.abs(_errors(name, asked, place)) / rated))


def _course_figures(found):
    """Return what _figures says of (Course as a dict, rated mass [kg]) of all runs."""
    def each(key):
        return [course[key] for course, _ in found if course[key] is not None]

    worst = [100.0 * course['worst'] / rated for course, rated in found
             if course['worst'] is not None]
    return {'later_percent': max(worst, default=None),
            'time_inside': float(np.mean(each('inside'))) if each('inside') else None,
            'mismatch': float(np.mean(each('mismatch'))) if each('mismatch') else None,
            'changes': sum(each('changes')) if each('changes') else None}
