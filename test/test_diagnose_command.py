"""`hand_load diagnose`: report, JSON, a usable model, a fine-tuned artefact."""

from dataclasses import replace
from datetime import datetime
import hashlib
import json
import shutil
import subprocess
import sys
from types import SimpleNamespace

from diagnose_helpers import assert_schema, diagnosed, JOINT, LOAD, model, recorded, TIMES
import numpy as np
import pytest

from hand_load_estimator.cli import main
from hand_load_estimator.learning import shards, training
from hand_load_estimator.learning.artefact import arm_of, read_artefact, write_artefact
from hand_load_estimator.learning.features import feature_count
from hand_load_estimator.learning.interval_factors import LEVELS
from hand_load_estimator.learning.network import LoadNetwork
from hand_load_estimator.recording import read_recording
from hand_load_estimator.residual import fine_tuning, load_error
from hand_load_estimator.residual.diagnosis import Diagnosis
from hand_load_estimator.residual.load_error import with_load_errors
from hand_load_estimator.torque import misread_weight
from hand_load_estimator.torque.model_file import read_model


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a model and recordings of an arm with a rubbing joint."""
    return recorded(tmp_path_factory.mktemp('diagnose'))


@pytest.fixture(scope='module')
def found(folder):
    """Return the report of the rubbing arm."""
    status, report = diagnosed(folder, 'run1', 'run2', '--test', 'test', 'loaded', out='found')
    assert status == 0
    return report


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


def test_the_report_says_where_the_residual_lived(found):
    """The rubbing joint's follows its velocity, in part only its direction, and then nothing."""
    before, after = (found['structure'][side] for side in ('before', 'after'))
    share = {name: values[JOINT] for name, values in before['share'].items()}
    assert share['velocity'] > 0.8 > share['direction'] and share['position'] < 0.1
    assert before['pairs'][JOINT][JOINT] > 0.8
    # All recordings are equally warm.
    assert set(before['share']['temperature']) == {None}
    known = [values[JOINT] for values in after['share'].values() if values[JOINT] is not None]
    assert max(known) < 0.05


@pytest.mark.parametrize('out, joint', [('found', JOINT), ('clean', 0)])
def test_the_model_says_when_it_was_diagnosed_and_what_it_left(folder, found, out, joint):
    """With an effect added, and as it was where nothing was found."""
    if out == 'clean':
        assert diagnosed(folder, 'clean1', '--test', 'clean2', out='clean')[1]['effects'] == []
    made = read_model(folder / out / 'model.yaml')
    age = datetime.now().astimezone() - datetime.fromisoformat(made.diagnosed)
    assert 0.0 <= age.total_seconds() < 600.0
    # Means over 0.2 s have less noise than single samples.
    assert 0.0 < made.residuals.sliding[joint] < 1.2 * model().noise[joint]
    assert read_model(folder / 'old.yaml').diagnosed is None


def test_the_load_is_estimated_better(found):
    """The estimator finds some of the friction by itself; of one run more cannot be asked."""
    error = found['load_error']
    assert error['after']['mass_rmse'] < error['before']['mass_rmse']
    assert error['after']['mass_rmse'] < 0.05 * LOAD.mass


def test_a_load_of_which_only_the_mass_is_known_tells_its_error(folder, found):
    """Errors of torques are those of the other test alone."""
    shutil.copytree(folder / 'loaded', folder / 'weighed')
    (folder / 'weighed' / 'load.yaml').write_text(f'mass: {LOAD.mass}\n')
    status, report = diagnosed(folder, 'run1', 'run2', '--test', 'test', 'weighed', out='weighing')
    error = report['load_error']
    assert status == 0 and error['before']['n'] == error['after']['n'] == 1
    assert error['after']['com_rmse'] is None
    assert error['after']['mass_rmse'] == pytest.approx(found['load_error']['after']['mass_rmse'],
                                                        rel=0.2)
    assert report['tested_on'] == 'test'


def test_an_assumed_load_tells_no_error():
    run = (SimpleNamespace(name='cell'), SimpleNamespace(load_known=('mass', 'com', 'assumed')),
           LOAD)
    zero = np.zeros(4)
    diagnosis = Diagnosis('four', model().robot.joints, zero, zero, zero, (), zero)
    with_reason = with_load_errors(diagnosis, model(), model(), [run])
    assert with_reason.load_before is None and with_reason.load_after is None
    assert with_reason.load_reason.startswith('the load of cell is assumed, not known')


def test_the_model_serves_estimate(folder, found):
    better = read_model(folder / 'found' / 'model.yaml')
    assert better.recording_names == ['made up', 'run1', 'run2']
    masses, stds = [], []
    for name in ('old.yaml', 'found/model.yaml'):
        out = folder / 'estimate.json'
        assert main(['estimate', str(folder / 'loaded'), '--model', str(folder / name), '--out',
                     str(out), '--method', 'bayes']) == 0
        said = json.loads(out.read_text())['mass']
        masses.append(said['mean'])
        stds.append(said['std'])
    # What the old model does not foretell is in its interval. One joint's friction is found while
    # the arm moves and not taken for another load, so little is left of it.
    assert stds[1] < stds[0]
    assert np.all(np.abs(np.array(masses) - LOAD.mass) < 3.0 * np.array(stds))
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


def test_what_an_earlier_diagnosis_left_goes(folder):
    """A correction or an artefact beside a report that tells of none would pass for its own."""
    out = folder / 'again'
    assert diagnosed(folder, 'clean1', out='again')[0] == 0
    (out / 'mine.txt').write_text('mine')
    shutil.copy(out / 'model.yaml', out / 'model_with_correction.yaml')
    (out / 'learned').mkdir()
    write_artefact(out / 'learned', {}, np.ones(1), {'made_by': 'diagnose'})
    assert diagnosed(folder, 'clean1', out='again')[0] == 0
    assert {p.name for p in out.rglob('*') if p.is_file()} == {
        'report.html', 'report.json', 'model.yaml', 'mine.txt'}


@pytest.mark.parametrize('card', [{'made_by': 'train', 'started_from': {'name': 'one'}}, {}])
def test_an_artefact_of_the_user_stays(folder, tmp_path, capsys, card):
    """Its card and weights were removed for those of an earlier diagnosis."""
    trained = tmp_path / 'learned'
    trained.mkdir()
    write_artefact(trained, {}, np.ones(1), card)
    capsys.readouterr()
    assert main(['diagnose', str(folder / 'clean1'), '--model', str(folder / 'old.yaml'),
                 '--out', str(tmp_path)]) == 2
    assert 'is of an artefact that no diagnosis made' in capsys.readouterr().err
    assert len(list(trained.iterdir())) == 2 and len(list(tmp_path.iterdir())) == 1


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
    for step in ('looking for contacts', 'computing the residual', 'tracing, round 1',
                 'estimating everything together', 'telling where the residual lives'):
        assert step in done.stderr


@pytest.fixture(scope='module')
def artefact(folder):
    """Return the folder of an artefact for the arm that does nothing yet."""
    robot = model().robot
    network = LoadNetwork(feature_count(robot.n), robot.n, 6)
    write_artefact(folder / 'artefact', {k: v.numpy() for k, v in network.state_dict().items()},
                   np.ones((10, len(LEVELS))),
                   {'name': 'as trained', **arm_of(robot)})
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
    assert card['made_by'] == 'diagnose'
    better = folder / 'tuned' / 'model.yaml'
    assert card['model']['sha256'] == hashlib.sha256(better.read_bytes()).hexdigest()
    assert main(['estimate', str(folder / 'loaded'), '--model', str(better), '--learned',
                 str(folder / 'tuned' / 'learned'), '--out', str(folder / 'out.json')]) == 0


def test_an_interrupted_fine_tuning_leaves_the_report(folder, artefact, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(fine_tuning, 'with_fine_tuning', interrupted)
    status, report = diagnosed(folder, 'run1', '--fine-tune', 'artefact', out='interrupted')
    assert status != 0 and [e['name'] for e in report['effects']] == ['viscous_friction']
    assert report['learned'] == {'done': 'not finished'}
    assert 'still being fine-tuned' in (folder / 'interrupted' / 'report.html').read_text()


def test_loads_are_judged_by_the_artefact_shipped_for_the_arm_too(folder, artefact, monkeypatch):
    """It is what a node runs unless told otherwise; without one there is nothing to say."""
    arguments = folder, 'run1', '--test', 'loaded'
    assert diagnosed(*arguments, out='unshipped')[1]['learned'] == {'done': 'kept'}
    monkeypatch.setattr(load_error, 'shipped_artefact', lambda _: artefact)
    _, report = diagnosed(*arguments, out='shipped')
    learned, plain = report['learned'], report['load_error']
    assert (learned['done'], learned['artefact']) == ('kept', 'as trained')
    before, after = (learned['load_error'][when] for when in ('before', 'after'))
    assert after['mass_rmse'] < before['mass_rmse'] and after['n'] == 1
    assert learned['load_error'] != plain
    assert 'by method lstm, the default, with the artefact <em>as trained</em>' in (
        folder / 'shipped' / 'report.html').read_text()


def test_runs_in_which_a_network_is_not_asked_are_counted(folder, artefact, monkeypatch):
    # `bayes` looks for what misreads weights a sample sooner than `lstm` at times.
    for name in ('LEAN', 'GAIN', 'TOOTH_FRICTION'):
        monkeypatch.setattr(misread_weight, name, 1e-9)
    recording = read_recording(folder / 'loaded')
    run = None, replace(recording, samples=recording.joint_samples), recording.load
    network = read_artefact(artefact, model().robot)
    plain = load_error.load_error(model(), [run])
    alone = load_error.load_error(model(), [run], network)
    assert (alone.not_asked, plain.not_asked) == (1, 0)
    assert alone.mass_rmse == pytest.approx(plain.mass_rmse, rel=1e-9), 'lstm is bayes there'


def test_an_unchanged_model_leaves_the_artefact_as_it_is(folder, artefact, capsys):
    status, report = diagnosed(folder, 'clean1', '--fine-tune', 'artefact', out='kept')
    assert status == 0 and report['learned'] == {'done': 'kept'}
    assert 'artefact is left as it is' in capsys.readouterr().err
    assert not (folder / 'kept' / 'learned').exists()
