"""An arm with a rubbing joint, its recordings, and `hand_load diagnose` on them."""

from dataclasses import replace
import json

from core_helpers import block, exact_model, messages, recording_of
import numpy as np

from hand_load_estimator.cli import main
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.recording import JointSample, RecordingWriter
from hand_load_estimator.torque.model_file import write_model

EMPTY, LOAD = LoadParameters(), block(2.0)
JOINT = 1            # of the hidden effect
TIMES = 2.0          # its coefficient over the declared one
SECONDS = 12.0
KEYS = {'schema', 'joints', 'before', 'after', 'noise_floor', 'effects', 'unexplained',
        'load_error', 'structure'}
EFFECT_KEYS = {'name', 'joints', 'parameters', 'explained', 'evidence', 'alternatives', 'verdict'}


def model():
    """Return the exact model of the arm, 2 % unsure of its friction."""
    return exact_model('four', doubt=0.02)


def rubbed(stream, joint=JOINT, times=TIMES):
    """Return Messages of an arm with so many times the declared viscous friction at a joint."""
    more = (times - 1.0) * 0.04 * model().robot.limits.torque[joint]
    out = []
    for m in stream:
        effort = np.array(m.effort)
        effort[joint] += more * m.velocity[joint]
        out.append(replace(m, effort=effort))
    return out


def write(path, stream, load=EMPTY, celsius=25.0):
    """Write a recording with its load.yaml; celsius: of all joints, or None without any."""
    recording = recording_of(stream, stream[0].names, 25.0 if celsius is None else celsius)
    with RecordingWriter(path) as writer:
        for sample in recording.samples:
            if isinstance(sample, JointSample) or celsius is not None:
                writer.write(sample)
    if load is not None:
        write_load_file(path / 'load.yaml', load)


def run(seed, load=EMPTY, **keywords):
    """Return the Messages of one run of the arm as modelled."""
    return messages(model(), load, SECONDS, seed=seed, size=1.2, **keywords)


def diagnosed(folder, *arguments, model_file='old.yaml', out='out'):
    """Run the command; return (status, report.json or None)."""
    report = folder / out / 'report.json'
    report.unlink(missing_ok=True)
    status = main(['diagnose', *(str(folder / a) if (folder / a).exists() else a
                                 for a in arguments),
                   '--model', str(folder / model_file), '--out', str(folder / out)])
    return status, json.loads(report.read_text()) if report.exists() else None


def refused(folder, capsys, *arguments, **keywords):
    """Return the one line that the command ends with; nothing is written."""
    capsys.readouterr()
    status, report = diagnosed(folder, *arguments, **keywords)
    said = capsys.readouterr().err.strip().splitlines()
    assert status == 2 and report is None
    assert said[-1].startswith('hand_load diagnose: ')
    assert sum(line.startswith('hand_load diagnose') for line in said) == 1
    return said[-1]


def assert_schema(report, n=4):
    """Hold a report to DESIGN section 4."""
    assert set(report) >= KEYS and report['schema'] == 'hand_load/diagnosis/1'
    assert report['joints'] == list(model().robot.joints)
    lists = [report['before']['torque_rmse'], report['after']['torque_rmse'],
             report['noise_floor'], report['unexplained']]
    assert all(len(values) == n for values in lists)
    for known, share in zip(report['before']['torque_rmse'], report['unexplained']):
        assert share is None if known is None else 0.0 <= share <= 1.0
    for effect in report['effects']:
        assert set(effect) >= EFFECT_KEYS and effect['verdict'] in ('confirmed', 'suspected')
        assert set(effect['joints']) <= set(report['joints']) and len(effect['explained']) == n
        assert all(set(p) == {'mean', 'std', 'unit'} for p in effect['parameters'].values())
        assert {'gain', 'gain_std', 'needed'} <= set(effect['evidence'])
        assert all(isinstance(name, str) for name in effect['alternatives'])
    assert_structure(report['structure'], n)
    error = report['load_error']
    if error is None:
        assert report['load_error_reason']
    else:
        assert set(error) == {'before', 'after'}
        assert all(set(side) == {'mass_rmse', 'com_rmse', 'n'} for side in error.values())


def assert_structure(structure, n):
    """Hold what a report says of where the residual lives to DESIGN section 4."""
    assert set(structure) == {'variables', 'noise', 'before', 'after'}
    assert {'position', 'velocity', 'direction', 'acceleration', 'gear torque', 'temperature',
            'time'} < set(structure['variables']) and len(structure['noise']) == n
    for side in (structure['before'], structure['after']):
        assert set(side) == {'torque_rmse', 'structured', 'share', 'chance', 'pairs',
                             'pairs_chance'}
        assert list(side['share']) == list(side['chance']) == structure['variables']
        rows = [side['structured'], *side['share'].values(), *side['chance'].values(),
                *side['pairs'], *side['pairs_chance']]
        assert len(rows) == 1 + 2 * len(structure['variables']) + 2 * n
        assert all(len(row) == n for row in rows)
        assert all(share is None or 0.0 <= share <= 1.0 for row in rows for share in row)


def recorded(out):
    """Write a model and recordings of an arm with a rubbing joint into a folder; return it."""
    write_model(out / 'old.yaml', model())
    for seed in (1, 2):
        write(out / f'run{seed}', rubbed(run(seed)))
        write(out / f'clean{seed}', run(seed))
    write(out / 'test', rubbed(run(3)))
    write(out / 'loaded', rubbed(run(4, LOAD)), LOAD)
    write(out / 'unsaid', run(5), None)
    return out
