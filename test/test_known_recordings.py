"""A diagnosis says which recordings the model was identified from, and judges what it writes."""

from dataclasses import replace
from functools import lru_cache
import shutil

from diagnose_helpers import diagnosed, JOINT, model, refused, rubbed, run, write
import numpy as np
import pytest
from residual_helpers import declared_model, on, recorded, ripple, viscous
from test_disturbance import pushed

from hand_load_estimator.files.recording_mark import content_of, message_digests, RecordingMark
from hand_load_estimator.recording import read_recording
from hand_load_estimator.report.diagnosis_json import diagnosis_content
from hand_load_estimator.report.diagnosis_page import page
from hand_load_estimator.residual.diagnose import diagnose, errors_of
from hand_load_estimator.residual.doubts.known_recordings import (known_by_name_only, known_names,
                                                                  made_from)
from hand_load_estimator.torque.model_file import read_model, write_model


def on_disk(evidence):
    """Return Evidence as if every one came from a recording of its own content."""
    return [replace(e, messages=np.arange(100 * k, 100 * k + 50, dtype=np.uint64))
            for k, e in enumerate(evidence)]


def made_of(model, evidence):
    """Return the TorqueModel as if it had been identified from Evidence."""
    return replace(model, recordings=tuple(e.mark for e in evidence))


def quarter_rms(model, evidence):
    """Return the error (n,) [Nm] of a model in the last quarter of every recording."""
    errors = [errors_of(model, [e])[int(0.75 * len(e.torque)) + 1:] for e in evidence]
    return np.sqrt(np.nanmean(np.concatenate(errors) ** 2, axis=0))


def test_recordings_are_known_by_their_content():
    one, two, three = on_disk(recorded()[:3])
    old = made_of(declared_model(), (one, two))
    renamed, namesake = replace(one, name='another name'), replace(three, name='run 0')
    assert made_from(old, (one, two)) and made_from(old, (two, renamed))
    assert not made_from(old, (one,)), 'what only the other told would be forgotten'
    assert not made_from(old, (namesake,)) and not made_from(old, (one, three))
    assert known_names(old, (namesake, renamed, three)) == ('another name',)
    assert not known_by_name_only(old, (one, namesake))


def test_a_name_alone_makes_no_recording_known():
    """Model files from before; not on disk, nothing is known of either."""
    one, two = on_disk(recorded()[:2])
    old = replace(declared_model(), recordings=(RecordingMark('run 0'), two.mark))
    assert not known_names(old, (one,))
    (said,) = known_by_name_only(old, (one, two))
    assert said.startswith('cannot tell whether the model was identified from run 0 because')
    assert not made_from(made_of(old, recorded()[:1]), recorded()[:1])


@lru_cache(None)
def as_given():
    """Return a diagnosis of the model's own recordings, all with more viscous friction."""
    evidence = on_disk(recorded(on(1, 5.0, viscous)))
    old = made_of(declared_model(), evidence)
    return old, evidence, *diagnose(old, evidence)


def test_the_error_told_is_that_of_the_model_written():
    """Its own recordings are fitted anew, and as no effect is missing then, it stays as it was."""
    old, evidence, diagnosis, better = as_given()
    assert better is old and not diagnosis.refitted
    np.testing.assert_array_equal(diagnosis.before, diagnosis.after)
    np.testing.assert_allclose(diagnosis.after, quarter_rms(old, evidence), rtol=0.02)
    # Fitted anew, which is not what is written, joint 1 would have the others' error.
    assert diagnosis.after[1] > 3.0 * quarter_rms(old, on_disk(recorded()))[1]


def test_what_the_model_has_seen_of_the_test_is_told():
    _, evidence, diagnosis, _ = as_given()
    names = ('run 0', 'run 1', 'run 2', 'run 3')
    assert diagnosis.seen == names
    assert diagnosis_content(diagnosis)['test_seen_by_model'] == list(names)
    assert 'the model was identified from run 0, run 1, run 2, run 3<' in page(diagnosis)
    tests = diagnose(made_of(declared_model(), evidence[3:]), evidence[:2], evidence[2:])[0]
    assert tests.seen == ('run 3',) and not tests.refitted
    unknown = diagnose(declared_model(), evidence[:2], evidence[2:])[0]
    assert unknown.seen == () and 'model was identified from' not in page(unknown)


def test_where_another_model_is_written_both_are_fitted_without_the_test():
    evidence = on_disk(recorded(on(2, 2.0, ripple)))
    diagnosis, better = diagnose(made_of(declared_model(), evidence), evidence)
    assert [f.name for f in diagnosis.findings] == ['torque_ripple']
    assert diagnosis.refitted and diagnosis.seen == ()
    assert 'fits without this part' in page(diagnosis)
    np.testing.assert_allclose(diagnosis.after, quarter_rms(better, evidence), rtol=0.02)


@pytest.mark.parametrize('rows, seconds', [(slice(700, 740), 0.8), (slice(300, 340), 0.0)])
def test_a_push_left_out_of_what_is_tested_on_is_told(rows, seconds):
    """In the last quarter of a recording, and in what is fitted."""
    diagnosis, _ = diagnose(declared_model(), pushed(rows))
    assert [f.name for f in diagnosis.findings] == ['external_contact']
    told = diagnosis_content(diagnosis)['test_left_out_seconds']
    # What is near an edge belongs to neither side.
    assert seconds <= told <= seconds + 0.5 * bool(seconds)
    assert ('acted from outside, as told below' in page(diagnosis)) == bool(seconds)


def test_with_tests_nothing_is_left_out_of_them():
    evidence = pushed(slice(700, 740), run=3)
    diagnosis, _ = diagnose(declared_model(), evidence[:3], evidence[3:])
    quiet = np.sqrt(np.nanmean(errors_of(declared_model(), recorded()[3:]) ** 2, axis=0))
    assert diagnosis.left_out == 0.0 and diagnosis.after[0] > 1.2 * quiet[0]


# The command.

@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with two days of recordings of the same names; the joint rubs on tuesday."""
    folder = tmp_path_factory.mktemp('days')
    for day, seeds, change in (('monday', (1, 2), list), ('tuesday', (3, 4), rubbed)):
        (folder / day).mkdir()
        for k, seed in enumerate(seeds, start=1):
            write(folder / day / f'run{k}', change(run(seed)))
    marks = [RecordingMark(f'run{k}', content_of(message_digests(
        read_recording(folder / f'monday/run{k}')))) for k in (1, 2)]
    write_model(folder / 'old.yaml', replace(model(), recordings=tuple(marks)))
    write_model(folder / 'names.yaml', replace(model(), recordings=tuple(
        RecordingMark(mark.name) for mark in marks)))
    return folder


@pytest.mark.parametrize('model_file, told', [('old.yaml', False), ('names.yaml', True)])
def test_tuesday_has_mondays_names_and_is_no_monday(folder, model_file, told):
    """By names alone nothing was found; told was 0.10 Nm, and what was written left 1.97 Nm."""
    status, report = diagnosed(folder, 'tuesday/run1', 'tuesday/run2', model_file=model_file)
    assert status == 0
    assert [(e['name'], e['joints']) for e in report['effects']] == [('viscous_friction', ['j1'])]
    assert report['before']['torque_rmse'][JOINT] > 5.0 * report['after']['torque_rmse'][JOINT]
    said = [s for s in report['cannot_tell'] if 'only the name' in s]
    assert len(said) == 2 * told and report['test_seen_by_model'] == []
    better = read_model(folder / 'out' / 'model.yaml')
    assert better.recording_names == ['run1', 'run2', 'run1', 'run2']
    assert len({mark.content for mark in better.recordings}) == 2 + 2 * (not told) + told


def test_its_own_recordings_are_known_wherever_they_lie(folder):
    shutil.copytree(folder / 'monday', folder / 'copies')
    (folder / 'copies' / 'run1').rename(folder / 'copies' / 'renamed')
    _, report = diagnosed(folder, 'copies/renamed', 'copies/run2')
    assert report['effects'] == [] and report['test_seen_by_model'] == ['renamed', 'run2']
    _, report = diagnosed(folder, 'tuesday/run1', 'tuesday/run2', '--test', 'monday/run1')
    assert report['test_seen_by_model'] == ['run1']
    assert 'identified from run1<' in (folder / 'out' / 'report.html').read_text()


@pytest.mark.parametrize('arguments', [
    ['monday/run1', 'monday/run2', 'monday/run1'], ['monday/run1', 'twin'],
    ['monday/run1', 'monday/run2', '--test', 'monday/run2'],
    ['monday/run1', '--test', 'twin', 'monday/run2'],
    ['monday/run1', '--test', 'monday/run2', 'monday/run2']])
def test_a_recording_given_twice_is_refused(folder, capsys, arguments):
    if not (folder / 'twin').exists():
        shutil.copytree(folder / 'monday' / 'run1', folder / 'twin')
    assert 'hold the same joint states' in refused(folder, capsys, *arguments, out='twice')
    assert not (folder / 'twice').exists()
