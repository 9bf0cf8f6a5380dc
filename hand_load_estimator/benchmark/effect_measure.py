"""One case from plant to result: hide the effects, record, diagnose, judge the better model."""

import time

import numpy as np

from ..errors import ConfigurationError
from ..plant.effects_file import parse_effects
from ..report.diagnosis_json import alternatives_content
from ..robot import load_robot
from .effect_cases import place
from .effect_errors import mass_errors, torque_rmse
from .effect_recordings import new_arm, record
from .effect_truth import model_change, true_change


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
    out['effects'] = [{'joints': [], **entry} for entry in entries]
    arm, recordings = prepared(case, entries, robot_path)
    diagnosis, better, seconds = diagnosis_of(arm.model, recordings.evidence, recordings.test)
    return {**out, **_said(diagnosis), 'seconds': seconds,
            'parameters': _parameters(robot, case.plant, entries, arm.model, better),
            **_errors(arm, better, recordings)}


def prepared(case, entries, robot_path):
    """Return the NewArm of a case and the Recordings of it with the effects of `entries`."""
    arm = new_arm(str(robot_path), case.plant)
    robot = arm.model.robot
    return arm, record(robot, case.plant, parse_effects(entries, robot))


def _said(diagnosis):
    return {'findings': [_finding(f) for f in diagnosis.findings],
            'cannot_tell': list(diagnosis.cannot_tell),
            'remains': [str(line) for line in diagnosis.remains],
            'unexplained': np.asarray(diagnosis.unexplained).tolist(),
            'told': {'before': np.asarray(diagnosis.before).tolist(),
                     'after': np.asarray(diagnosis.after).tolist()}}


def _finding(finding):
    evidence = finding.evidence
    return {'name': finding.name, 'joints': list(finding.joints), 'verdict': finding.verdict,
            'alternatives': alternatives_content(finding), 'advice': finding.advice,
            'changed': bool(finding.changed),
            'variables': list(finding.variables),
            'parameters': {name: [float(mean), float(std), unit]
                           for name, (mean, std, unit) in finding.parameters.items()},
            'gain': float(evidence.gain), 'gain_std': float(evidence.gain_std),
            'needed': float(evidence.needed), 'next_best': evidence.next_best,
            'margin': None if evidence.margin is None else float(evidence.margin)}


def _parameters(robot, plant, entries, before, after):
    """Return effect, parameter, truth and estimate of all figures that can be compared."""
    out = []
    for entry in entries:
        told = model_change(robot, before, after, entry)
        out += [{'effect': entry['name'], 'parameter': name, 'truth': value,
                 'estimate': told[name]}
                for name, value in true_change(robot, plant, entry).items()]
    return out


def _errors(arm, better, recordings):
    """Return errors of the new arm's model and of the better one, and without the effect."""
    return {
        'torque': {'before': torque_rmse(arm.model, recordings.test).tolist(),
                   'after': torque_rmse(better, recordings.test).tolist(),
                   'without': arm.torque.tolist()},
        'mass': {'before': mass_errors(arm.model, recordings.loaded),
                 'after': mass_errors(better, recordings.loaded), 'without': arm.mass}}
