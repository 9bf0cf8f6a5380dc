"""`hand_load diagnose` on bad input: it says why and makes up nothing."""

from dataclasses import replace

from core_helpers import four_axes, message_noise, Message, messages, swing, torque_of
from diagnose_helpers import (assert_schema, diagnosed, EMPTY, JOINT, model, recorded, refused,
                              rubbed, run, SECONDS, write)
import numpy as np
import pytest

from hand_load_estimator.cli import main
from hand_load_estimator.robot import robot_from_content
from hand_load_estimator.torque.model_file import write_model


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a model and recordings of an arm with a rubbing joint."""
    return recorded(tmp_path_factory.mktemp('diagnose'))


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


def test_a_load_that_is_there_all_the_time_undeclared_is_said(folder, capsys):
    said = refused(folder, capsys, 'loaded', '--load', 'none')
    assert 'looks loaded with about 2' in said and 'declared: none' in said and '--load' in said
    assert said.count('loaded: ') == 1


def test_rejected_messages_are_said(folder, capsys):
    """Most are in another unit: what is left is too short, but not for want of motion."""
    stream = [m if k >= 600 else replace(m, effort=1e6 * np.array(m.effort))
              for k, m in enumerate(run(1)[:800])]
    write(folder / 'spoiled', stream)
    said = refused(folder, capsys, 'spoiled')
    assert '600 of ' in said and 'implausible effort' in said and 'hand_load check' in said


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


def test_a_warm_arm_without_temperatures_has_no_other_friction(folder, capsys):
    """Its model says what warmth does, so that friction of another temperature is no finding."""
    for seed in (1, 2):
        write(folder / f'warm{seed}', run(seed, temperature=42.0), celsius=None)
    status, report = diagnosed(folder, 'warm1', 'warm2')
    assert status == 0 and report['effects'] == []
    assert max(report['before']['torque_rmse']) > 2.0 * max(model().noise)
    said = capsys.readouterr().out
    assert 'cannot tell effects of temperature because none was recorded' in said
    assert 'the torque model fits' not in said


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


def assert_nothing_made_up(capsys, status, report):
    """A refusal that says whose the model is not, or a report that confirms no effect."""
    said = capsys.readouterr().err.strip().splitlines()[-1]
    if status == 2:
        assert said.startswith('hand_load diagnose: ') and 'belongs to another robot' in said
    else:
        assert [e['name'] for e in report['effects'] if e['verdict'] == 'confirmed'] == []


def test_other_joint_names_are_refused(folder, capsys):
    """Alone, and among recordings of the right arm."""
    write(folder / 'stranger', renamed(run(1)))
    said = refused(folder, capsys, 'stranger')
    assert 'stranger' in said and 'axis_0, axis_1' in said and run(1)[0].names[0] in said
    assert 'stranger' in refused(folder, capsys, 'clean1', 'stranger')
    assert 'stranger' in refused(folder, capsys, 'clean1', '--test', 'stranger')


def test_a_recording_of_which_nothing_is_usable_says_why(folder, capsys):
    nothing = [replace(m, effort=np.full(len(m.effort), np.nan)) for m in run(1)[:300]]
    write(folder / 'nothing', nothing)
    said = refused(folder, capsys, 'nothing')
    assert 'among 300: 300 not finite' in said and 'hand_load check' in said


def test_effort_of_the_other_sign_is_refused(folder, capsys):
    write(folder / 'reversed', reversed_effort(run(2)))
    said = refused(folder, capsys, 'clean1', 'reversed')
    assert 'reversed' in said and 'another' in said


def test_effort_of_the_other_sign_is_refused_as_a_test_too(folder, capsys):
    """Otherwise the errors before and after would be those of another arm."""
    if not (folder / 'reversed').exists():
        write(folder / 'reversed', reversed_effort(run(2)))
    assert 'reversed' in refused(folder, capsys, 'clean2', '--test', 'reversed')


def test_another_mounting_makes_up_no_effect(folder, capsys):
    write_model(folder / 'wall.yaml', on_the_wall())
    assert_nothing_made_up(capsys, *diagnosed(folder, 'clean1', 'clean2', model_file='wall.yaml'))


def test_another_arm_among_good_ones_makes_up_no_effect(folder, capsys):
    write(folder / 'mixed', messages(on_the_wall(), EMPTY, SECONDS, seed=2, size=1.2))
    assert_nothing_made_up(capsys, *diagnosed(folder, 'clean1', 'mixed'))


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


@pytest.mark.parametrize('name', ['report.html', 'report.json', 'model.yaml',
                                  'model_with_correction.yaml', 'learned/card.json'])
def test_a_file_of_the_user_stays(folder, tmp_path, capsys, name):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text('mine')
    assert main(['diagnose', str(folder / 'clean1'), '--model', str(folder / 'old.yaml'),
                 '--out', str(tmp_path)]) == 2
    assert f'{path}: is there, and no earlier result' in capsys.readouterr().err
    assert path.read_text() == 'mine'


def test_the_model_that_is_diagnosed_stays(folder, tmp_path, capsys):
    path = tmp_path / 'model.yaml'
    write_model(path, model())
    assert main(['diagnose', str(folder / 'clean1'), '--model', str(path), '--out',
                 str(tmp_path)]) == 2
    assert f'{path}: is what the command reads' in capsys.readouterr().err
