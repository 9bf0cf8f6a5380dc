"""Training is picked up after kill -9 and then gives what an undisturbed one gives."""

import json
import os
from pathlib import Path
import subprocess
import sys
import time

from core_helpers import exact_model
import numpy as np
import pytest
from ros_helpers import ROOT
from safetensors.numpy import load_file

from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.learning.artefact import read_artefact
from hand_load_estimator.learning.training_loop import begin_work, end_work
from hand_load_estimator.torque.model_file import write_model

# Small batches, so that a shard is a second's work; killed at a given line of progress.
SCRIPT = '''
import os, signal, sys, threading
from hand_load_estimator.learning import shards, training
shards.BATCH = 2
recipe = training.Recipe(sequences=8, calibration=2, validation=2, passes=15, hidden=8)
kill_at, delay = sys.argv[3], float(sys.argv[4])
def write(text):
    print(text, flush=True)
    if kill_at and text.startswith(kill_at):
        threading.Timer(delay, os.kill, (os.getpid(), signal.SIGKILL)).start()
training.train(sys.argv[1], sys.argv[2], recipe, 'cpu', write)
print('finished')
'''
JOB = {'model': {'undated': ''}}


def train(model, folder, kill_at='', delay=0.0):
    """Run a training in a process of its own; return (exit status, output)."""
    environment = {**os.environ, 'OMP_NUM_THREADS': '1', 'PYTHONPATH': str(ROOT)}
    # To a file: workers that outlive their parent would keep a pipe open for ever.
    said = folder.with_suffix('.txt')
    with open(said, 'w', encoding='utf-8') as output:
        done = subprocess.run([sys.executable, '-c', SCRIPT, str(model), str(folder), kill_at,
                               str(delay)], stdout=output, stderr=subprocess.STDOUT, timeout=120,
                              check=False, env=environment)
    return done.returncode, said.read_text(encoding='utf-8')


def processes_of(folder):
    """Return the ids of processes whose command line names a folder."""
    found = []
    for path in Path('/proc').glob('[0-9]*/cmdline'):
        try:
            if str(folder).encode() in path.read_bytes():
                found.append(int(path.parent.name))
        except OSError:
            continue
    return found


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    """Return folder, what each run printed, and worker processes that outlived a kill."""
    out = tmp_path_factory.mktemp('training')
    write_model(out / 'model.yaml', exact_model('four', doubt=0.02))
    said = {'whole': train(out / 'model.yaml', out / 'whole')}
    said['killed in sequences'] = train(out / 'model.yaml', out / 'again',
                                        'sequences (training) 2/4')
    end = time.monotonic() + 5.0
    while (left := processes_of(out / 'again')) and time.monotonic() < end:
        time.sleep(0.1)
    for number in left:
        os.kill(number, 9)
    said['killed in steps'] = train(out / 'model.yaml', out / 'again', 'training step 25', 0.05)
    said['resumed'] = train(out / 'model.yaml', out / 'again')
    return out, said, left


def test_the_kills_came_when_they_should(runs):
    _, said, _ = runs
    assert said['whole'][0] == said['resumed'][0] == 0, said['resumed'][1]
    for name in ('killed in sequences', 'killed in steps'):
        status, text = said[name]
        assert status == -9 and 'finished' not in text
    assert 'training step' not in said['killed in sequences'][1]


def test_what_was_done_is_not_done_again(runs):
    _, said, _ = runs
    first = said['killed in steps'][1].splitlines()[0]
    assert not first.startswith(('sequences (training) 1/', 'sequences (training) 2/')), first
    steps = [line for line in said['resumed'][1].splitlines() if 'training step' in line]
    assert steps[0].startswith('training step 50/60')
    assert not any(line.startswith('sequences') for line in said['resumed'][1].splitlines())


def test_the_result_is_that_of_an_undisturbed_training(runs):
    out, _, _ = runs
    whole, again = (load_file(out / name / 'lstm.safetensors') for name in ('whole', 'again'))
    assert set(whole) == set(again)
    for name, value in whole.items():
        np.testing.assert_allclose(again[name], value, rtol=1e-6, atol=1e-7, err_msg=name)
    cards = [json.loads((out / name / 'card.json').read_text()) for name in ('whole', 'again')]
    assert cards[0]['held_out'] == cards[1]['held_out']
    assert cards[0]['recipe'] == cards[1]['recipe']


def test_training_learnt_something(runs):
    out, _, _ = runs
    weights = load_file(out / 'whole' / 'lstm.safetensors')
    assert np.abs(weights['joint_head.weight']).max() > 1e-3


def test_no_worker_outlives_a_killed_training(runs):
    """Left-over workers hold memory for ever and write into the folder of the next training."""
    assert not runs[2]


def test_work_is_cleared_away_and_the_artefact_is_small(runs):
    out, _, _ = runs
    files = sorted(p.name for p in (out / 'again').rglob('*'))
    assert files == ['card.json', 'lstm.safetensors']
    assert sum(p.stat().st_size for p in (out / 'again').iterdir()) < 5e6


def test_progress_tells_the_time_left(runs):
    text = runs[1]['whole'][1]
    assert 'sequences (training) 4/4' in text and 'training step 60/60' in text
    assert 'min left' in text


def test_the_artefact_runs(runs):
    out, _, _ = runs
    model = exact_model('four')
    assert read_artefact(out / 'again', model.robot).card['effort_kind'] == 'motor_torque'
    pipeline = build_pipeline(out / 'model.yaml', 'lstm', str(out / 'again'))
    assert pipeline.method.name == 'lstm'


def test_the_card_says_where_it_comes_from(runs):
    card = json.loads((runs[0] / 'whole' / 'card.json').read_text())
    assert card['joints'] == ['j0', 'j1', 'j2', 'j3'] and card['recipe']['sequences'] == 8
    assert card['seeds'] == {'training': 1_000_000, 'calibration': 2_100_000,
                             'validation': 2_000_000}
    assert {'coverage_of_95', 'mass_rmse_kg_lstm', 'mass_rmse_kg_without_network'} \
        <= set(card['held_out'])


def test_another_job_in_the_same_folder_is_refused(runs, tmp_path, capsys):
    out, _, _ = runs
    (tmp_path / 'work').mkdir(parents=True)
    (tmp_path / 'work' / 'job.json').write_text('{"recipe": {}, "model": ""}')
    assert main(['train', '--model', str(out / 'model.yaml'), '--out', str(tmp_path)]) == 2
    assert 'unfinished training of another model, recipe or start' in capsys.readouterr().err


def test_work_says_whose_it_is_until_nothing_else_is_left(tmp_path, monkeypatch):
    """Killed while it was cleared away, work without its note passed for that of the next job."""
    shards = tmp_path / 'work' / 'training'
    shards.mkdir(parents=True)
    for path in (shards / 'a.safetensors', shards.parent / 'checkpoint.safetensors',
                 shards.parent / 'job.json'):
        path.touch()
    left = []

    def watched(path, missing_ok=False, unlink=Path.unlink):
        left.append({p.name for p in shards.parent.rglob('*') if p.is_file()})
        unlink(path, missing_ok)

    monkeypatch.setattr(Path, 'unlink', watched)
    end_work(shards.parent, {'training': [shards / 'a.safetensors']})
    assert all('job.json' in names for names in left) and left[-1] == {'job.json'}
    assert len(left) == 3 and not shards.parent.exists()


def test_a_folder_of_the_users_called_work_is_left_alone(tmp_path):
    """It was taken for the training's own, and everything in it removed at the end."""
    (tmp_path / 'work' / 'run1').mkdir(parents=True)
    with pytest.raises(ConfigurationError, match='files that are of no training'):
        begin_work(tmp_path, JOB, {'training': range(2)})
    assert [p.name for p in tmp_path.rglob('*')] == ['work', 'run1']


@pytest.mark.parametrize('content', [b'{', b'\xff'])
def test_work_with_a_damaged_note_is_refused(tmp_path, content):
    (tmp_path / 'work').mkdir()
    (tmp_path / 'work' / 'job.json').write_bytes(content)
    with pytest.raises(ConfigurationError, match='job.json: is damaged'):
        begin_work(tmp_path, JOB, {'training': range(2)})


def test_what_others_put_into_the_work_stays(tmp_path):
    work = begin_work(tmp_path, JOB, {'training': range(2)})
    (work / 'training').mkdir()
    names = ('training/0_2.safetensors', 'training/0_2.safetensors.7.part', 'training/notes.txt',
             'checkpoint.safetensors', 'mine.safetensors')
    for name in names:
        (work / name).touch()
    end_work(work, {'training': [work / names[0]]})
    assert sorted(str(p.relative_to(work)) for p in work.rglob('*') if p.is_file()) \
        == ['mine.safetensors', 'training/notes.txt']


@pytest.mark.parametrize('arguments, word', [
    (['--sequences', '0'], '--sequences'), (['--passes', '-1'], '--passes'),
    (['--model', 'nowhere.yaml'], 'nowhere.yaml')])
def test_wrong_arguments_end_with_two(runs, tmp_path, capsys, arguments, word):
    known = ['--model', str(runs[0] / 'model.yaml'), '--out', str(tmp_path / 'out')]
    assert main(['train', *known, *arguments]) == 2
    said = capsys.readouterr().err.strip()
    assert word in said and '\n' not in said
