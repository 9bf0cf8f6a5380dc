"""
Read and write torque model files: self-contained YAML a person can read and edit.

Each parameter stands with mean, std and unit; correlations stand at the end. Editing a mean or a
std changes just that; the covariance is rebuilt from standard deviations and correlations.
"""

from dataclasses import replace
from datetime import datetime
import hashlib
import json

import numpy as np
import yaml

from ..effects import EFFECTS
from ..errors import ConfigurationError
from ..files.configuration import Section, read_yaml
from ..files.recording_mark import RecordingMark
from ..files.whole_file import whole_file
from ..load import PRODUCT_ORDER
from ..robot import robot_from_content
from ..torque_model import Residuals, TorqueModel
from .columns import EffectUse

# One contact bears a joint's Coulomb friction and Stribeck peak.
SCHEMA = 'hand_load/torque_model/3'
# Before two did, and before that friction turned along the filtered motion: the same parameters
# meant another torque.
OLD_SCHEMAS = 'hand_load/torque_model/1', 'hand_load/torque_model/2'
# Shapes that files from before they were there have at their defaults.
_NEWER = frozenset({'impact'})
_PRODUCT_UNITS = ('kg', 'kg m', 'kg m', 'kg m') + ('kg m^2',) * 6


class _Dumper(yaml.SafeDumper):
    """Short lists on one line, long texts as blocks."""


def _flow_list(dumper, data):
    flat = all(isinstance(v, (int, float, str)) for v in data)
    return dumper.represent_sequence('tag:yaml.org,2002:seq', data, flow_style=flat)


def _block_text(dumper, text):
    style = '|' if '\n' in text else None
    return dumper.represent_scalar('tag:yaml.org,2002:str', text, style=style)


def _flow_mapping(dumper, data):
    return dumper.represent_mapping('tag:yaml.org,2002:map', data.items(),
                                    flow_style='unit' in data or 'content' in data)


_Dumper.add_representer(list, _flow_list)
_Dumper.add_representer(dict, _flow_mapping)
_Dumper.add_representer(str, _block_text)


def _number(value, digits=8):
    return float(f'{value:.{digits}g}')


def _parameter(mean, std, unit):
    return {'mean': _number(mean), 'std': _number(std, 6), 'unit': unit}


def model_content(model):
    """Return the plain mapping that a model file holds."""
    robot, std = model.robot, np.sqrt(np.diag(model.covariance))
    links = {joint: {name: _parameter(model.mean[10 * j + k], std[10 * j + k], unit)
                     for k, (name, unit) in enumerate(zip(PRODUCT_ORDER, _PRODUCT_UNITS))}
             for j, joint in enumerate(robot.joints)}
    effects = []
    for use, where in model.slices():
        parameters = {name: _parameter(model.mean[i], std[i], unit) for i, (name, unit) in
                      zip(range(where.start, where.stop), use.effect.parameters)}
        whole = use.effect.whole_arm
        entry = {'name': use.name,
                 'joints': list(robot.joints) if whole else [robot.joints[use.joint]],
                 'parameters': parameters}
        if use.told_shape:
            entry['shape'] = {name: float(v) for name, v in use.told_shape.items()}
        if use.shape_std:
            entry['shape_std'] = {name: float(v) for name, v in use.shape_std.items()}
        effects.append(entry)
    scale = np.where(std > 0.0, std, 1.0)
    correlation = model.covariance / np.outer(scale, scale)
    rows = [[_number(correlation[i, k], 12) for k in range(i)] for i in range(len(std))]
    return {
        'schema': SCHEMA,
        'robot': robot.file.content,
        'links_identified': model.links_declared,
        'effects': effects,
        'residual': _residual_content(model.residuals, robot.joints),
        'recordings': [_mark_content(mark) for mark in model.recordings],
        'diagnosed': model.diagnosed,
        'temperatures': [float(t) for t in model.temperatures] if model.temperatures else None,
        'links': links,
        'correlations': rows if np.any(model.covariance) else []}


def _mark_content(mark):
    return {'name': mark.name, 'content': mark.content} if mark.content else mark.name


def _residual_content(residuals, joints):
    content = {'torque_noise': [_number(v, 4) for v in residuals.rmse],
               'low_frequency_density': [_number(v, 4) for v in residuals.intensity],
               'load_share': _number(residuals.load_share, 4),
               'drift_std': [[_number(v, 4) for v in row] for row in residuals.drift]}
    if residuals.unmoved is not None and residuals.unmoved.any():
        content['unmoved_joints'] = [name for name, unmoved in zip(joints, residuals.unmoved)
                                     if unmoved]
    if residuals.sliding is not None:
        content['sliding_residual'] = [_number(v, 4) if np.isfinite(v) else None
                                       for v in residuals.sliding]
    return content


_HEADER = """\
# Torque model of hand_load_estimator: tau = rigid body + effects, with what is known of each.
# links: products in pinocchio's order about each joint's frame [kg, kg m, kg m^2].
# residual: torque_noise [Nm] (held-out RMS while sliding; of unmoved_joints what may be left of
#   their friction), low_frequency_density [Nm^2 s],
#   load_share: of all variances stated here, the part an estimate of the load suffers from,
#   drift_std [Nm, Nm, Nm s/rad] of offset, Coulomb level, viscous coefficient from day to day,
#   sliding_residual [Nm] (RMS of means over 0.2 s while sliding, null: not known) when diagnosed.
# recordings: content is a digest of the joint states, by which a recording is known again.
# correlations: lower triangle without the diagonal, links first, then effects as listed.
"""


def write_model(path, model):
    """Write a TorqueModel; the file appears whole or not at all: a node may read it again."""
    text = yaml.dump(model_content(model), Dumper=_Dumper, sort_keys=False, width=10 ** 6,
                     allow_unicode=True)
    with whole_file(path) as part:
        part.write_text(_HEADER + text, encoding='utf-8')


def model_digest(model):
    """Return a digest of what a TorqueModel predicts; the same before and after a file."""
    uses = [[use.name, use.joint, use.told_shape] for use in model.uses]
    text = json.dumps([model.robot.joints, model.robot.effort.kind, uses,
                       [_number(value) for value in model.mean]])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def undated_digest(model):
    """Return a digest of all that the file of a TorqueModel says but when it was diagnosed."""
    text = json.dumps(model_content(replace(model, diagnosed=None)))
    return hashlib.sha256(text.encode()).hexdigest()


def read_model(path):
    """Return the TorqueModel of a file; ConfigurationError says what is wrong with it."""
    section = Section(read_yaml(path), path)
    schema = section.get('schema', SCHEMA)
    if schema in OLD_SCHEMAS:
        raise ConfigurationError(
            f'{path}: schema', 'is of an earlier version, whose friction turned in another way',
            schema, SCHEMA, 'identify it again from its recordings (hand_load identify)')
    section.text('schema', (SCHEMA,))
    robot = robot_from_content(section.get('robot', 'the robot file\'s content'),
                               f'{path}: robot')
    uses, values = _read_effects(section, robot, path)
    mean, std = _read_links(section, robot)
    mean, std = np.concatenate([mean, values[0]]), np.concatenate([std, values[1]])
    residual = section.section('residual')
    residuals = Residuals(residual.vector('torque_noise', robot.n, 1e-9),
                          residual.vector('low_frequency_density', robot.n, 1e-12),
                          _read_drift(residual, robot.n),
                          _read_sliding(residual, robot.n),
                          residual.number('load_share', 1e-3) if residual.has('load_share')
                          else 1.0, _read_unmoved(residual, robot.joints))
    residual.refuse_unknown()
    temperatures = (tuple(section.vector('temperatures', 2))
                    if section.has('temperatures') else None)
    model = TorqueModel(robot, uses, section.flag('links_identified'), mean,
                        _covariance(section, std), residuals,
                        _read_recordings(section, path), temperatures, _read_diagnosed(section))
    section.refuse_unknown()
    return model


def _read_recordings(section, path):
    """Return RecordingMarks; files from before the content was kept have plain names."""
    allowed = 'a list of names, or of mappings with name and content'
    entries = section.get('recordings', allowed)
    if not isinstance(entries, list) or not all(isinstance(e, (str, dict)) for e in entries):
        section.fail('recordings', 'is not usable', entries, allowed)
    return tuple(RecordingMark(entry) if isinstance(entry, str) else
                 _read_mark(Section(entry, f'{path}: recordings[{k}]'))
                 for k, entry in enumerate(entries))


def _read_mark(entry):
    mark = RecordingMark(entry.text('name'), entry.text('content'))
    entry.refuse_unknown()
    return mark


def _read_diagnosed(section):
    """Return the time of the last diagnosis; files from before it was kept have none."""
    if not section.has('diagnosed'):
        return None
    text = section.text('diagnosed')
    try:
        datetime.fromisoformat(text)
    except ValueError:
        section.fail('diagnosed', 'is no time', text, "a time as '2026-03-01T14:30:00+01:00'")
    return text


def _read_sliding(section, n):
    if not section.has('sliding_residual'):
        return None
    values = section.get('sliding_residual', f'{n} numbers or null')
    if not isinstance(values, list) or len(values) != n or not all(
            v is None or isinstance(v, (int, float)) and 0.0 <= v < np.inf for v in values):
        section.fail('sliding_residual', 'is not usable', values, f'{n} numbers >= 0 or null')
    return np.array([np.nan if v is None else v for v in values])


def _read_unmoved(section, joints):
    """Return which joints (n,) no recording moved; files from before it was kept name none."""
    allowed = f'a list of some of {", ".join(joints)}'
    names = section.get('unmoved_joints', allowed) if section.has('unmoved_joints') else []
    if not isinstance(names, list) or any(name not in joints for name in names):
        section.fail('unmoved_joints', 'is not usable', names, allowed)
    return np.isin(joints, names)


def _read_drift(section, n):
    rows = section.get('drift_std', f'{n} rows of 3 numbers')
    array = np.array(rows, dtype=float) if _is_matrix(rows, n, 3) else np.empty(0)
    if array.shape != (n, 3) or not np.isfinite(array).all() or (array < 0.0).any():
        section.fail('drift_std', 'is not usable', rows, f'{n} rows of 3 numbers >= 0')
    return array


def _is_matrix(rows, count, width):
    return isinstance(rows, list) and len(rows) == count and all(
        isinstance(row, list) and len(row) == width
        and all(isinstance(v, (int, float)) for v in row) for row in rows)


def _read_links(section, robot):
    links = section.section('links')
    mean, std = [], []
    for joint in robot.joints:
        entry = links.section(joint)
        for name in PRODUCT_ORDER:
            value = entry.section(name)
            mean.append(value.number('mean'))
            std.append(value.number('std', 0.0))
            value.has('unit')
            value.refuse_unknown()
        entry.refuse_unknown()
    links.refuse_unknown()
    return np.array(mean), np.array(std)


def _read_effects(section, robot, path):
    entries = section.get('effects', 'a list of effects')
    if not isinstance(entries, list):
        section.fail('effects', 'is not usable', entries, 'a list of effects')
    uses, mean, std = [], [], []
    for k, content in enumerate(entries):
        entry = Section(content, f'{path}: effects[{k}]')
        name = entry.text('name', tuple(EFFECTS))
        shape, shape_std = _read_shape(entry, EFFECTS[name])
        names = entry.names('joints')
        for joint in names[:1] if EFFECTS[name].whole_arm else names:
            if joint not in robot.joints:
                entry.fail('joints', 'names a joint the robot does not have', joint,
                           ', '.join(robot.joints))
            place = 0 if EFFECTS[name].whole_arm else robot.joints.index(joint)
            uses.append(EffectUse(name, place, shape, shape_std))
            values = entry.section('parameters')
            for parameter, _ in EFFECTS[name].parameters:
                value = values.section(parameter)
                mean.append(value.number('mean'))
                std.append(value.number('std', 0.0))
                value.has('unit')
                value.refuse_unknown()
            values.refuse_unknown()
        entry.refuse_unknown()
    return tuple(uses), (np.array(mean), np.array(std))


def _read_shape(entry, effect):
    if not _needed(effect) and not entry.has('shape'):
        return {}, {}
    std = _numbers(entry.section('shape_std'), effect, 0.0, ()) if entry.has('shape_std') else {}
    return _numbers(entry.section('shape'), effect, 1e-9), std


def _needed(effect):
    return [s.name for s in effect.shapes if s.there(s.default) and s.name not in _NEWER]


def _numbers(section, effect, least, needed=None):
    """
    Return the numbers of an effect's shapes; those that need not be there may be missing.

    needed: names of those that must be; by default what has a finite value of its own.
    """
    if needed is None:
        needed = _needed(effect)
    values = {s.name: section.number(s.name, least) for s in effect.shapes
              if s.name in needed or section.has(s.name)}
    section.refuse_unknown()
    return values


def _covariance(section, std):
    rows = section.get('correlations', 'a lower triangle')
    correlation = np.eye(len(std))
    if rows:
        if not isinstance(rows, list) or not all(isinstance(r, list) for r in rows) \
                or [len(r) for r in rows] != list(range(len(std))):
            section.fail('correlations', 'have the wrong size', None,
                         f'{len(std)} rows of 0, 1, ... numbers; put [] for none after '
                         'editing the list of effects')
        for i, row in enumerate(rows):
            if not all(isinstance(v, (int, float)) and abs(v) <= 1.0 + 1e-6 for v in row):
                section.fail('correlations', f'are not usable in row {i}', None,
                             'numbers in [-1, 1]')
            correlation[i, :i] = correlation[:i, i] = row
    return correlation * np.outer(std, std)
