"""`hand_load diagnose`: report, JSON, a usable model; bad input says why, makes up nothing."""

from dataclasses import replace
import hashlib
import json
import subprocess
import sys

from core_helpers import (block, exact_model, four_axes, message_noise, Message, messages,
                          recording_of, swing, torque_of)
import numpy as np
import pytest

from hand_load_estimator.cli import main
from hand_load_estimator.learning import shards, training
from hand_load_estimator.learning.artefact import write_artefact
from hand_load_estimator.learning.features import feature_count
from hand_load_estimator.learning.interval_factors import LEVELS
from hand_load_estimator.learning.network import LoadNetwork
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.load_file import write_load_file
from hand_load_estimator.model_file import read_model, write_model
from hand_load_estimator.recording import JointSample, RecordingWriter
from hand_load_estimator.robot import robot_from_content

EMPTY, LOAD = LoadParameters(), block(2.0)
JOINT = 1            # of the hidden effect
TIMES = 2.0          # its coefficient over the declared one
SECONDS = 12.0
KEYS = {'schema', 'joints', 'before', 'after', 'noise_floor', 'effects', 'unexplained',
        'load_error'}
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


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a model and recordings of an arm with a rubbing joint."""
    out = tmp_path_factory.mktemp('diagnose')
    write_model(out / 'old.yaml', model())
    for seed in (1, 2):
        write(out / f'run{seed}', rubbed(run(seed)))
        write(out / f'clean{seed}', run(seed))
    write(out / 'test', rubbed(run(3)))
    write(out / 'loaded', rubbed(run(4, LOAD)), LOAD)
    write(out / 'unsaid', run(5), None)
    return out


def diagnosed(folder, *arguments, model_file='old.yaml', out='out'):
    """Run the command; return (status, report.json or None)."""
    report = folder / out / 'report.json'
    report.unlink(missing_ok=True)
    status = main(['diagnose', *(str(folder / a) if (folder / a).exists() else a
                                 for a in arguments),
                   '--model', str(folder / model_file), '--out', str(folder / out)])
    return status, json.loads(report.read_text()) if report.exists() else None


@pytest.fixture(scope='module')
def found(folder):
    """Return the report of the rubbing arm."""
    status, report = diagnosed(folder, 'run1', 'run2', '--test', 'test', 'loaded', out='found')
    assert status == 0
    return report


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
    error = report['load_error']
    if error is None:
        assert report['load_error_reason']
    else:
        assert set(error) == {'before', 'after'}
        assert all(set(side) == {'mass_rmse', 'com_rmse', 'n'} for side in error.values())


# What it says and writes.

def test_the_report_keeps_the_schema(folder, found):
    assert_schema(found)
    text = (folder / 'found' / 'report.json').read_text()
    assert 'NaN' not in text and 'Infinity' not in text
    assert found['recordings'] == ['run1', 'run2']
    assert found['load_error']['before']['n'] == found['load_error']['after']['n'] == 1


def test_the_hidden_effect_is_named_and_its_error_gone(found):
    effects = [(e['name'], e['joints'], e['verdict']) for e in found['effects']]
    assert effects == [('viscous_friction', ['j1'], 'confirmed')]
    truth = TIMES * 0.04 * model().robot.limits.torque[JOINT]
    coefficient = found['effects'][0]['parameters']['coefficient']
    assert abs(coefficient['mean'] - truth) < 4.0 * coefficient['std'] + 0.05 * truth
    before, after = (np.array(found[side]['torque_rmse']) for side in ('before', 'after'))
    assert after[JOINT] < 0.4 * before[JOINT]
    assert (after < 1.1 * before).all() and (after < 1.3 * model().noise).all()


def test_the_load_is_estimated_better(found):
    error = found['load_error']
    assert error['after']['mass_rmse'] < 0.7 * error['before']['mass_rmse']
    assert error['after']['mass_rmse'] < 0.05 * LOAD.mass


def test_the_model_serves_estimate(folder, found):
    better = read_model(folder / 'found' / 'model.yaml')
    assert set(better.recordings) == {'made up', 'run1', 'run2'}
    masses = []
    for name in ('old.yaml', 'found/model.yaml'):
        out = folder / 'estimate.json'
        assert main(['estimate', str(folder / 'loaded'), '--model', str(folder / name), '--out',
                     str(out), '--method', 'bayes']) == 0
        masses.append(json.loads(out.read_text())['mass']['mean'])
    assert abs(masses[1] - LOAD.mass) < 0.7 * abs(masses[0] - LOAD.mass)
    assert found['load_error']['after']['mass_rmse'] == pytest.approx(
        abs(masses[1] - LOAD.mass), abs=2e-3)


def test_the_better_model_has_nothing_left_to_find(folder, found):
    """Diagnosed once more with recordings it has not seen, nothing is found."""
    status, report = diagnosed(folder, 'test', 'loaded', model_file='found/model.yaml')
    assert status == 0 and report['effects'] == []


def test_the_page_is_one_file_that_names_the_effect(folder, found):
    page = (folder / 'found' / 'report.html').read_text()
    assert '<html' in page and 'j1' in page and 'viscous' in page
    assert 'src="http' not in page and 'href="http' not in page


def test_json_prints_the_report(folder, capsys):
    status, report = diagnosed(folder, 'clean1', 'clean2', '--json')
    assert status == 0
    assert json.loads(capsys.readouterr().out) == report
    assert_schema(report)


def test_nothing_is_found_on_an_arm_as_modelled(folder, capsys):
    """The model comes back as it was, and the reason for no load error is told."""
    status, report = diagnosed(folder, 'clean1', 'clean2')
    assert status == 0 and report['effects'] == []
    assert report['before'] == report['after'] and report['load_error'] is None
    assert 'report.html' in capsys.readouterr().out
    np.testing.assert_allclose(read_model(folder / 'out' / 'model.yaml').mean, model().mean,
                               rtol=1e-7)


@pytest.mark.parametrize('name', ['clean1', 'clean2'])
def test_nothing_is_found_in_one_short_recording(folder, name):
    """What the motion filter makes of friction at a reversal is no effect of the arm."""
    status, report = diagnosed(folder, name)
    assert status == 0 and report['effects'] == []


def test_recordings_with_a_known_load_serve_too(folder):
    status, report = diagnosed(folder, 'run1', 'loaded', '--test', 'test')
    assert status == 0
    assert [(e['name'], e['joints']) for e in report['effects']] == [('viscous_friction', ['j1'])]


def test_as_a_process_of_its_own(folder):
    done = subprocess.run(
        [sys.executable, '-m', 'hand_load_estimator', 'diagnose', 'clean1', '--model', 'old.yaml',
         '--out', 'own', '--json'], cwd=folder, capture_output=True, text=True, timeout=120,
        check=True)
    assert json.loads(done.stdout)['schema'] == 'hand_load/diagnosis/1'
    assert (folder / 'own' / 'report.html').exists() and 'clean1' in done.stderr


@pytest.fixture(scope='module')
def artefact(folder):
    """Return the folder of an artefact for the arm that does nothing yet."""
    robot = model().robot
    network = LoadNetwork(feature_count(robot.n), robot.n, 6)
    write_artefact(folder / 'artefact', {k: v.numpy() for k, v in network.state_dict().items()},
                   np.ones((10, len(LEVELS))),
                   {'name': 'as trained', 'joints': list(robot.joints),
                    'effort_kind': robot.effort.kind})
    return folder / 'artefact'


def test_the_artefact_is_fine_tuned_from_the_better_model(folder, artefact, monkeypatch, capsys):
    monkeypatch.setattr(shards, 'BATCH', 2)
    monkeypatch.setattr(training, 'FINE_TUNING', training.Recipe(2, 2, 2, 1, learning_rate=1e-3))
    status, report = diagnosed(folder, 'run1', '--test', 'loaded', '--fine-tune', 'artefact',
                               out='tuned')
    assert status == 0 and 'training step 1/1' in capsys.readouterr().err
    learned = report['learned']
    assert learned['done'] == 'fine-tuned' and learned['started_from'] == 'as trained'
    # Both with the better model, which method bayes uses for `after`; one run of 2 kg.
    for side in ('before', 'after'):
        assert learned['load_error'][side]['n'] == 1
        assert learned['load_error'][side]['mass_rmse'] < 0.1 * LOAD.mass
    assert learned['load_error']['before'] != learned['load_error']['after']
    card = json.loads((folder / 'tuned' / 'learned' / 'card.json').read_text())
    better = folder / 'tuned' / 'model.yaml'
    assert card['model']['sha256'] == hashlib.sha256(better.read_bytes()).hexdigest()
    assert main(['estimate', str(folder / 'loaded'), '--model', str(better), '--learned',
                 str(folder / 'tuned' / 'learned'), '--out', str(folder / 'out.json')]) == 0


def test_an_unchanged_model_leaves_the_artefact_as_it_is(folder, artefact, capsys):
    status, report = diagnosed(folder, 'clean1', '--fine-tune', 'artefact', out='kept')
    assert status == 0 and report['learned'] == {'done': 'kept'}
    assert 'artefact is left as it is' in capsys.readouterr().err
    assert not (folder / 'kept' / 'learned').exists()


# Bad input.

@pytest.mark.parametrize('name, word', [('ur10e', 'other joints'), ('nowhere', 'nowhere')])
def test_an_artefact_that_does_not_fit_is_refused_at_once(folder, capsys, name, word):
    """Before minutes of diagnosis, which has not said a word yet."""
    assert word in refused(folder, capsys, 'clean1', '--fine-tune', name, out=f'refused {name}')
    assert not (folder / f'refused {name}').exists()


def test_one_second_is_too_little(folder, capsys):
    write(folder / 'second', run(1)[200:300])
    assert '4.8 s' in refused(folder, capsys, 'second')


def test_an_arm_at_rest_tells_nothing(folder, capsys):
    write(folder / 'still', messages(model(), EMPTY, SECONDS, rest=99.0))
    assert 'no joint moves' in refused(folder, capsys, 'still')


def test_a_recording_must_say_its_load(folder, capsys):
    assert 'load' in refused(folder, capsys, 'unsaid')
    status, report = diagnosed(folder, 'unsaid', 'clean1', '--load', 'none')
    assert status == 0 and report['effects'] == []


def stuck(joint, seed):
    """Return Messages of an arm one joint of which never moves."""
    arm, rng = model(), np.random.default_rng(seed)
    times = np.arange(int(SECONDS * 100.0)) / 100.0
    q, v, a = swing(arm.robot, times, 0.6, seed, 1.2)
    q[:, joint], v[:, joint], a[:, joint] = 0.4, 0.0, 0.0
    torque = torque_of(arm, q, v, a, 0.01, 25.0, [(0, EMPTY)])
    torque += rng.normal(size=torque.shape) * message_noise(arm.robot)
    return [Message(100.0 + t, arm.robot.joints, *row) for t, *row in zip(times, q, v, torque)]


def test_a_joint_that_never_moved_is_not_judged(folder):
    """Its friction is unknown, so what it shows (here 5 Nm too much) is no effect of it."""
    for seed in (1, 2):
        held = [replace(m, effort=m.effort + np.array([0.0, 0.0, 5.0, 0.0]))
                for m in stuck(2, seed)]
        write(folder / f'held{seed}', held)
    status, report = diagnosed(folder, 'held1', 'held2')
    assert status == 0
    assert any(s.startswith('cannot tell') and 'j2' in s for s in report['cannot_tell'])
    assert not any('j2' in e['joints'] for e in report['effects'])
    assert_schema(report)
    # Nothing is known of its error while sliding, and nothing is claimed.
    assert report['before']['torque_rmse'][2] is None


@pytest.mark.parametrize('name, celsius, words', [('none', None, 'none was recorded'),
                                                  ('same', 31.0, 'only 0.0 K')])
def test_without_warming_nothing_is_said_of_temperature(folder, name, celsius, words):
    for seed in (1, 2):
        write(folder / f'{name}{seed}', rubbed(run(seed, temperature=celsius or 25.0)),
              celsius=celsius)
    status, report = diagnosed(folder, f'{name}1', f'{name}2')
    assert status == 0
    assert any(s.startswith('cannot tell effects of temperature because') and words in s
               for s in report['cannot_tell'])
    assert [(e['name'], e['joints']) for e in report['effects']] == [('viscous_friction', ['j1'])]


def test_saturated_effort_is_left_out(folder):
    """A drive at its limit is said so, and makes no effect of the arm."""
    for seed in (1, 2):
        stream = run(seed)
        effort = np.array([m.effort for m in stream])
        top = np.quantile(np.abs(effort[:, JOINT]), 0.8)
        effort[:, JOINT] = np.clip(effort[:, JOINT], -top, top)
        write(folder / f'limited{seed}', [replace(m, effort=e) for m, e in zip(stream, effort)])
    status, report = diagnosed(folder, 'limited1', 'limited2')
    assert status == 0
    assert sum('limited' in s and 'j1' in s and '%' in s for s in report['cannot_tell']) == 2
    assert [e for e in report['effects'] if e['verdict'] == 'confirmed'] == []


def on_the_wall():
    """Return the model of the same arm mounted on a wall."""
    content = {**four_axes().file.content, 'gravity': [0.0, 9.81, 0.0]}
    return replace(model(), robot=robot_from_content(content, 'other'))


def renamed(stream):
    return [replace(m, names=tuple(f'axis_{k}' for k in range(4))) for m in stream]


def reversed_effort(stream):
    return [replace(m, effort=-np.array(m.effort)) for m in stream]


def assert_nothing_made_up(status, report):
    """A refusal, or a report that confirms no effect."""
    assert status == 2 or [e['name'] for e in report['effects']
                           if e['verdict'] == 'confirmed'] == []


def test_other_joint_names_are_refused(folder, capsys):
    """Alone, and among recordings of the right arm."""
    write(folder / 'stranger', renamed(run(1)))
    assert 'stranger' in refused(folder, capsys, 'stranger')
    assert 'stranger' in refused(folder, capsys, 'clean1', 'stranger')
    assert 'stranger' in refused(folder, capsys, 'clean1', '--test', 'stranger')


def test_effort_of_the_other_sign_is_refused(folder, capsys):
    write(folder / 'reversed', reversed_effort(run(2)))
    said = refused(folder, capsys, 'clean1', 'reversed')
    assert 'reversed' in said and 'another' in said


def test_effort_of_the_other_sign_is_refused_as_a_test_too(folder, capsys):
    """Otherwise the errors before and after would be those of another arm."""
    if not (folder / 'reversed').exists():
        write(folder / 'reversed', reversed_effort(run(2)))
    assert 'reversed' in refused(folder, capsys, 'clean2', '--test', 'reversed')


def test_another_mounting_makes_up_no_effect(folder):
    write_model(folder / 'wall.yaml', on_the_wall())
    assert_nothing_made_up(*diagnosed(folder, 'clean1', 'clean2', model_file='wall.yaml'))


def test_another_arm_among_good_ones_makes_up_no_effect(folder):
    write(folder / 'mixed', messages(on_the_wall(), EMPTY, SECONDS, seed=2, size=1.2))
    assert_nothing_made_up(*diagnosed(folder, 'clean1', 'mixed'))


@pytest.mark.parametrize('arguments, word', [
    (['nowhere'], 'nowhere'), (['old.yaml'], 'old.yaml'), (['damaged'], 'damaged'),
    (['clean1', '--test', 'nowhere'], 'nowhere'),
    (['clean1', '--load', 'nowhere.yaml'], 'nowhere.yaml')])
def test_what_cannot_be_read_is_named(folder, capsys, arguments, word):
    damaged = folder / 'damaged'
    if not damaged.exists():
        damaged.mkdir()
        for path in (folder / 'clean1').iterdir():
            data = path.read_bytes()
            (damaged / path.name).write_bytes(data if path.suffix == '.yaml' else data[:500])
    assert word in refused(folder, capsys, *arguments)


def test_a_model_that_is_none_is_named(folder, capsys):
    (folder / 'broken.yaml').write_text('schema: something else\n')
    assert 'broken.yaml' in refused(folder, capsys, 'clean1', model_file='broken.yaml')


def test_a_place_that_is_a_file_is_named(folder, capsys):
    (folder / 'file').write_text('')
    capsys.readouterr()
    status = main(['diagnose', str(folder / 'clean1'), '--model', str(folder / 'old.yaml'),
                   '--out', str(folder / 'file')])
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert status == 2 and said.startswith('hand_load diagnose: ') and 'file' in said
