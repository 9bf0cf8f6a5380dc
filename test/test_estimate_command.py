"""`hand_load estimate`: the JSON of DESIGN section 4, causal; wrong input ends with status 2."""

from dataclasses import replace
import json
import subprocess
import sys

from core_helpers import block, exact_model, Message, messages, pipeline_of, recording_of
import numpy as np
import pytest

from hand_load_estimator.cli import main
from hand_load_estimator.estimators.estimation import estimate_recording
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.recording import RecordingWriter
from hand_load_estimator.torque.model_file import write_model

LOAD = block(2.0)


def write_bag(path, recording):
    with RecordingWriter(path) as writer:
        for sample in recording.samples:
            writer.write(sample)


def estimated(stream, model=None):
    """Return the JSON content of a stream."""
    model = model or exact_model('four')
    return estimate_recording(pipeline_of(model), recording_of(stream, model.robot.joints))


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a model and recordings."""
    out, model = tmp_path_factory.mktemp('estimate'), exact_model('four')
    write_model(out / 'model.yaml', model)
    joints = model.robot.joints
    stream = messages(model, LOAD, 5.0)
    write_bag(out / 'run', recording_of(stream, joints))
    write_bag(out / 'cut', recording_of(stream[:300], joints))
    write_bag(out / 'still', recording_of(messages(model, LOAD, 2.0, rest=9.0), joints))
    write_bag(out / 'gripper', recording_of([Message(
        m.stamp, ('finger',), np.ones(1), np.ones(1), np.ones(1)) for m in stream[:50]], ()))
    write_bag(out / 'deaf', recording_of([Message(
        m.stamp, m.names, m.position, m.velocity, np.nan * m.effort) for m in stream[:50]],
        joints))
    return out


def command(folder, run, *more):
    """Run the command and return (exit status, content of the file or None)."""
    out = folder / f'{run}.json'
    out.unlink(missing_ok=True)
    status = main(['estimate', str(folder / run), '--model', str(folder / 'model.yaml'),
                   '--out', str(out), '--method', 'bayes', *more])
    return status, json.loads(out.read_text()) if out.exists() else None


def test_the_schema(folder):
    status, content = command(folder, 'run')
    assert status == 0
    assert content['schema'] == 'hand_load/estimate/1' and content['method'] == 'bayes'
    assert content['intervals'] == 'as the method has them'
    assert content['frame'] == 'tip' and content['status'] == 'DETERMINED'
    assert content['samples'] == 500 and content['rejected'] == {}
    assert np.array(content['com']['mean']).shape == np.array(content['com']['std']).shape == (3,)
    assert np.array(content['inertia']['mean']).shape == (6,)
    covariance = np.array(content['covariance'])
    assert covariance.shape == (10, 10) and len(content['determined']) == 10
    stds = [content['mass']['std'], *content['com']['std'], *content['inertia']['std']]
    np.testing.assert_allclose(stds, np.sqrt(np.diag(covariance)), rtol=1e-9)
    assert all(isinstance(done, bool) for done in content['determined'])
    history = content['history']
    assert set(history) == {'t', 'mass', 'mass_std', 'com', 'com_std'}
    assert {len(column) for column in history.values()} == {len(history['t'])}
    assert np.array(history['com']).shape == np.array(history['com_std']).shape \
        == (len(history['t']), 3)
    for column in history.values():
        assert np.isfinite(np.array(column)).all()


def test_the_answer_is_right_in_message_order(folder):
    _, content = command(folder, 'run')
    got = np.concatenate([[content['mass']['mean']], content['com']['mean'],
                          content['inertia']['mean']])
    std = np.sqrt(np.diag(content['covariance']))
    assert (np.abs(got - LOAD.to_message()) < 3.5 * std).all()
    assert std[0] < 0.05


def test_the_history_begins_with_the_prior(folder):
    _, content = command(folder, 'run')
    prior = pipeline_of(exact_model('four')).estimate(0.0)
    history = content['history']
    assert history['t'][0] == 0.0
    assert history['mass'][0] == pytest.approx(prior.mean[0], abs=1e-5)
    assert history['mass_std'][0] == pytest.approx(prior.std[0], abs=1e-5)
    assert history['com_std'][0] == pytest.approx(prior.std[1:4], abs=1e-5)
    assert history['mass_std'][-1] < 0.1 * history['mass_std'][0]


@pytest.mark.parametrize('rate', [30.0, 60.0, 94.0, 100.0, 125.0, 500.0])
def test_an_entry_at_least_every_twenty_milliseconds_where_messages_allow(rate):
    stream = messages(exact_model('four'), LOAD, 1.5, rate=rate)
    t = np.array(estimated(stream)['history']['t'])
    assert np.diff(t).max() <= max(0.02, 1.0 / rate) + 1e-5
    assert t[0] == 0.0 and t[-1] > 1.5 - 0.03 - 1.0 / rate


def test_a_jittery_log_of_94_hertz_has_its_entries_too():
    rng = np.random.default_rng(1)
    stream = messages(exact_model('four'), LOAD, 2.0, rate=94.0)
    steps = rng.choice([0.010, 0.011, 0.012, 0.002], len(stream), p=[0.6, 0.2, 0.15, 0.05])
    jittery = [Message(100.0 + t, m.names, m.position, m.velocity, m.effort)
               for t, m in zip(np.cumsum(steps), stream)]
    assert np.diff(estimated(jittery)['history']['t']).max() <= 0.02 + 1e-5


@pytest.mark.parametrize('end', [5, 50, 237, 300])
def test_the_history_does_not_know_the_future(end):
    stream = messages(exact_model('four'), LOAD, 4.0)
    whole, cut = estimated(stream)['history'], estimated(stream[:end])['history']
    assert len(cut['t']) >= end // 3
    for name, column in cut.items():
        assert column == whole[name][:len(column)], name


def test_the_command_is_causal_too(folder):
    _, whole = command(folder, 'run')
    _, cut = command(folder, 'cut')
    count = len(cut['history']['t'])
    assert count > 140
    for name, column in cut['history'].items():
        assert column == whole['history'][name][:count], name


def test_a_recording_that_loops_goes_on():
    """A log that begins anew (a looped recording, a restarted simulation) is used to its end."""
    model = exact_model('four')
    stream = messages(model, LOAD, 3.0)
    again = [Message(m.stamp - 90.0, m.names, m.position, m.velocity, m.effort)
             for m in messages(model, LOAD, 4.0, seed=1)]
    content = estimated(stream + again)
    assert content['rejected'] == {'clock_restart': 1}
    assert content['status'] == 'DETERMINED'
    once = estimated(stream)
    assert content['mass']['std'] < once['mass']['std']
    assert len(content['history']['t']) > 1.5 * len(once['history']['t'])
    assert np.isfinite(content['history']['mass']).all()


def test_load_yaml_is_never_read(folder):
    _, content = command(folder, 'run')
    write_load_file(folder / 'run' / 'load.yaml', block(9.0))
    _, told = command(folder, 'run')
    (folder / 'run' / 'load.yaml').write_text('mass: nonsense')
    status, nonsense = command(folder, 'run')
    (folder / 'run' / 'load.yaml').unlink()
    assert status == 0 and told == content == nonsense


def test_an_arm_at_rest_is_readable_and_tells_little(folder, capsys):
    status, content = command(folder, 'still')
    assert status == 0 and content['status'] == 'WAITING_FOR_MOTION'
    assert not all(content['determined'][:4])
    assert 'WAITING_FOR_MOTION' in capsys.readouterr().out


def test_stamps_that_repeat_are_no_arm_at_rest():
    stream = messages(exact_model('four'), LOAD, 5.0)
    content = estimated([replace(m, stamp=stream[0].stamp) for m in stream])
    assert content['status'] == 'WAITING_FOR_MOTION'
    assert f'{len(stream) - 1} repeated stamp' in content['reason']
    still = estimated(messages(exact_model('four'), LOAD, 2.0, rest=9.0))
    assert 'at rest friction hides it' in still['reason']


def test_other_joints_only_is_readable_and_says_whose(folder, capsys):
    status, content = command(folder, 'gripper')
    assert status == 0 and content['status'] == 'NO_DATA'
    assert content['reason'].startswith('joint states name finger, but none of ')
    assert content['reason'] in capsys.readouterr().out


def test_no_data_says_why_and_no_mass(folder, capsys):
    status, content = command(folder, 'deaf')
    assert status == 0 and content['status'] == 'NO_DATA' and content['samples'] == 0
    assert np.isfinite(np.array(content['covariance'])).all()
    assert content['history']['t'] == []
    said = capsys.readouterr().out
    assert content['reason'] in said and 'mass' not in said


def test_the_reason_is_told_unless_the_load_is_determined(folder, capsys):
    _, still = command(folder, 'still')
    assert f'\n{still["reason"]}\n' in capsys.readouterr().out
    _, run = command(folder, 'run')
    said = capsys.readouterr().out
    assert run['reason'] not in said and 'less than nothing' not in said


def test_a_mass_below_zero_is_told_as_a_contradiction(folder, capsys):
    """A model from an arm that held 2 kg, and nobody said so: the bare arm weighs less."""
    model = exact_model('four')
    bare = messages(model, block(0.0), 5.0)
    lighter = [Message(m.stamp, m.names, m.position, m.velocity, 2.0 * m.effort - loaded.effort)
               for m, loaded in zip(bare, messages(model, LOAD, 5.0))]
    write_bag(folder / 'lighter', recording_of(lighter, model.robot.joints))
    status, content = command(folder, 'lighter')
    assert status == 0 and content['mass']['mean'] < -1.0
    assert 'no load weighs less than nothing' in capsys.readouterr().out


def test_file_is_strict_json(folder):
    for run in ('run', 'deaf'):
        command(folder, run)
        text = (folder / f'{run}.json').read_text()
        assert 'NaN' not in text and 'Infinity' not in text


@pytest.mark.parametrize('arguments', [
    ['nowhere', '--model', 'model.yaml'], ['model.yaml', '--model', 'model.yaml'],
    ['run', '--model', 'nowhere.yaml'], ['run', '--model', 'run'],
    ['run', '--model', 'model.yaml', '--method', 'magic'],
    ['run', '--model', 'model.yaml', '--learned', 'run'],
    ['run', '--model', 'model.yaml', '--joint-states', 'other'],
    ['damaged', '--model', 'model.yaml']])
def test_wrong_input_ends_with_two_and_one_line(folder, capsys, monkeypatch, arguments):
    monkeypatch.chdir(folder)
    damaged = folder / 'damaged'
    if not damaged.exists():
        damaged.mkdir()
        for path in (folder / 'run').iterdir():
            if path.is_file():
                (damaged / path.name).write_bytes(
                    path.read_bytes() if path.suffix == '.yaml' else path.read_bytes()[:500])
    out = folder / 'never.json'
    assert main(['estimate', *arguments, '--out', str(out)]) == 2
    said = capsys.readouterr().err.strip()
    assert '\n' not in said and said.startswith('hand_load estimate: ')
    assert any(word in said for word in ('nowhere', 'model.yaml', 'run', 'magic', 'other',
                                         'damaged'))
    assert not out.exists()


def test_learned_takes_the_name_of_a_shipped_artefact(folder, capsys):
    """Found, and then refused for what it is: made for another arm."""
    assert command(folder, 'run', '--method', 'lstm', '--learned', 'ur10e') == (2, None)
    said = capsys.readouterr().err
    assert 'learned/ur10e/card.json: belongs to other joints' in said
    assert command(folder, 'run', '--method', 'lstm', '--learned', 'ur11') == (2, None)
    said = capsys.readouterr().err
    assert 'neither a path nor a shipped file' in said and 'ur10e_gru' in said


def test_an_artefact_of_another_network_is_told_by_its_name(folder, capsys):
    assert main(['estimate', str(folder / 'run'), '--model', 'ur10e', '--learned', 'ur10e_gru',
                 '--method', 'lstm', '--out', str(folder / 'never.json')]) == 2
    said = capsys.readouterr().err
    assert "is another network; got 'gru'" in said and 'take method gru' in said


def test_estimating_needs_neither_torch_nor_simulator(folder):
    """In a process of its own, so that nothing another test imported can hide it."""
    code = ('import sys\n'
            'from hand_load_estimator.cli import main\n'
            f'status = main(["estimate", {str(folder / "run")!r}, "--model", '
            f'{str(folder / "model.yaml")!r}, "--out", {str(folder / "own.json")!r}])\n'
            'found = [m for m in sys.modules if m.split(".")[0] in ("torch", "mujoco", "rclpy") '
            'or m.startswith("hand_load_estimator.plant")]\n'
            'print(status, found)\n')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True,
                          timeout=60, check=True)
    assert done.stdout.splitlines()[-1] == '0 []'
