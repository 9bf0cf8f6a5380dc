"""One case from plant to result: hide the effects, record, diagnose, judge the better model."""

from dataclasses import dataclass, replace
import time

import numpy as np

from ..errors import ConfigurationError
from ..plant.effects_file import parse_effects
from ..report.diagnosis_json import diagnosis_content
from ..robot import load_robot
from .effect_cases import ALONE, BLIND, place
from .effect_errors import differences, mass_errors, rms, torque_rmse
from .effect_outcome import naming
from .effect_recordings import (new_arm, NewArm, record, Recordings, tested_floors,
                                without_temperatures)
from .effect_truth import model_change, stated, true_change


@dataclass(frozen=True)
class Prepared:
    """Of a case: the arm before anything happened, what is recorded after, floors of the tests."""

    arm: NewArm
    recordings: Recordings
    floors: tuple


def diagnosis_of(model, evidence, test):
    """Return (Diagnosis, better TorqueModel, seconds)."""
    # Here, so that the base suite needs nothing of the diagnosis.
    from ..residual.diagnose import diagnose
    began = time.perf_counter()
    diagnosis, better = diagnose(model, list(evidence), list(test), progress=lambda text: None)
    return diagnosis, better, time.perf_counter() - began


def case_result(case, robot_path):
    """Return the plain result of an EffectCase; `skipped` says why there is nothing to measure."""
    robot = load_robot(robot_path)
    out = {'label': case.label, 'kind': case.kind, 'plant': case.plant,
           'effects': [{'name': h.name, 'strength': h.strength, 'joints': []}
                       for h in case.hidden]}
    try:
        entries = place(robot, case)
    except ConfigurationError as error:
        return {**out, 'skipped': str(error)}
    out['effects'] = [{'joints': [], 'strength': h.strength, **entry}
                      for h, entry in zip(case.hidden, entries)]
    made = prepared(case, entries, robot_path)
    arm, recordings = made.arm, made.recordings
    diagnosis, better, seconds = diagnosis_of(arm.model, recordings.evidence, recordings.test)
    said = _said(diagnosis)
    return {**out, **said, 'seconds': seconds,
            'parameters': _parameters(robot, case.plant, entries, (arm.model, better),
                                      said['findings']),
            **_errors(arm, better, recordings, made.floors)}


def prepared(case, entries, robot_path):
    """Return what is Prepared of a case with the effects of `entries`."""
    arm = new_arm(str(robot_path), case.plant)
    effects = parse_effects(entries, arm.model.robot)
    recordings = record(arm.model.robot, case.plant, effects)
    if case.kind == BLIND:
        recordings = without_temperatures(recordings)
    if case.kind == ALONE:
        # Each motion and temperature on some of the plants.
        k = case.plant % len(recordings.evidence)
        recordings = replace(recordings, evidence=recordings.evidence[k:k + 1])
    return Prepared(arm, recordings, tuple(tested_floors(arm.model, case.plant, effects)))


def _said(diagnosis):
    """Return what report.json says, findings as it has them."""
    content = diagnosis_content(diagnosis)
    return {'findings': content['effects'], 'cannot_tell': content['cannot_tell'],
            'remains': content['remains'], 'unexplained': content['unexplained'],
            'told': {when: content[when]['torque_rmse'] for when in ('before', 'after')}}


def _parameters(robot, plant, entries, models, findings):
    """
    Return {effect, parameter, truth, estimate, std} of all figures that can be compared.

    models: TorqueModels before and after. estimate, std: None where nothing says them.
    """
    out = []
    for entry in entries:
        told = model_change(robot, *models, entry)
        finding = naming(findings, {'joints': [], **entry})
        for name, truth in true_change(robot, plant, entry).items():
            mean, std = (None, None) if finding is None else stated(finding, name)
            out.append({'effect': entry['name'], 'parameter': name, 'truth': truth,
                        'estimate': told.get(name, mean), 'std': std})
    return out


def _errors(arm, better, recordings, floors):
    """Return errors of the new arm's model and of the better one, and without the effect."""
    motions, rows = [e.motion for e in recordings.test], [floor.rows for floor in floors]
    left = {'before': [differences(arm.model, motion) for motion in motions],
            'after': [differences(better, motion) for motion in motions],
            'known': [floor.left for floor in floors]}
    return {
        'torque': {'before': torque_rmse(arm.model, recordings.test).tolist(),
                   'after': torque_rmse(better, recordings.test).tolist(),
                   'without': arm.torque.tolist()},
        'seen': {'joints': list(arm.model.robot.joints), 'share': _judged(floors).tolist(),
                 **{when: rms(those, rows).tolist() for when, those in left.items()}},
        'mass': {'before': mass_errors(arm.model, recordings.loaded),
                 'after': mass_errors(better, recordings.loaded), 'without': arm.mass}}


def _judged(floors):
    """Return the share (n,) of the rows of moving joints that Floors judge."""
    judged, moved = (sum(getattr(floor, name).sum(axis=0) for floor in floors)
                     for name in ('rows', 'moving'))
    return judged / np.maximum(moved, 1)
