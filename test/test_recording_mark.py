"""A recording is known by its content: copies and parts are found, no name is asked."""

from dataclasses import replace

from core_helpers import four_axes
from diagnose_helpers import EMPTY, model, run, write
import numpy as np
import pytest
import yaml

from hand_load_estimator.cli import main
from hand_load_estimator.errors import RecordingError
from hand_load_estimator.files.recording_mark import message_digests, refuse_repeats
from hand_load_estimator.identification.evidence import Evidence, prepare, recording_numbers
from hand_load_estimator.recording import JointSample, read_recording, Recording
from hand_load_estimator.stream.joint_stream import motion_of
from hand_load_estimator.torque.model_file import write_model


def evidence_of(folder, name, stream):
    """Return the Evidence of a recording with these Messages, written and read again."""
    write(folder / name, stream)
    recording = read_recording(folder / name)
    return prepare(four_axes(), name, motion_of(four_axes(), recording)[0], EMPTY, recording)


@pytest.fixture(scope='module')
def stream():
    return run(1)


@pytest.fixture(scope='module')
def first(stream, tmp_path_factory):
    return evidence_of(tmp_path_factory.mktemp('first'), 'run1', stream)


def test_the_content_is_that_of_the_messages(stream, first, tmp_path):
    """The same wherever it lies; another with one other effort, or one message less."""
    again = evidence_of(tmp_path, 'run1', stream)
    assert again.mark == first.mark and len(first.mark.content) == 16
    changed = [*stream[:-1], replace(stream[-1], effort=stream[-1].effort + 1e-9)]
    others = [evidence_of(tmp_path, name, other) for name, other in (
        ('changed', changed), ('shorter', stream[:-1]), ('other', run(2)))]
    assert len({first.mark.content, *(e.mark.content for e in others)}) == 4


def test_two_recordings_of_one_name_are_two(stream, first, tmp_path):
    """monday/run1 and tuesday/run1; parts of one recording are one."""
    tuesday = evidence_of(tmp_path, 'run1', run(2))
    part = replace(first, torque=first.torque[:5])
    assert tuesday.name == first.name and recording_numbers([first, tuesday, part]) == [0, 1, 0]


def test_copies_and_overlapping_parts_are_refused(stream, first, tmp_path):
    copy, part = evidence_of(tmp_path, 'copy', stream), evidence_of(tmp_path, 'part', stream[900:])
    other = evidence_of(tmp_path, 'other', run(2))
    refuse_repeats([first, other])
    refuse_repeats([first], [other])
    for recordings, test, words in (
            ([first, other, copy], [], 'run1 and copy: hold the same joint states.*only once'),
            ([first, first], [], 'run1 and run1'), ([part, other, first], [], '300 of 300'),
            ([first, other], [copy], 'run1 and copy.*not among those to learn from'),
            ([other], [first, part], 'run1 and part.*to test on only once')):
        with pytest.raises(RecordingError, match=words):
            refuse_repeats(recordings, test)


def test_a_message_told_twice_is_no_copy(stream, first, tmp_path):
    """As a driver's last one, told again when the next recording begins."""
    after = [stream[-1], *(replace(m, stamp=m.stamp + 20.0) for m in run(2))]
    refuse_repeats([first, evidence_of(tmp_path, 'after', after)])


def test_what_is_not_on_disk_is_passed_over(first):
    unknown = Evidence('run1', first.motion, first.torque)
    assert unknown.mark.content == '' and not len(unknown.messages)
    refuse_repeats([unknown, unknown], [first])


@pytest.mark.parametrize('command', ['identify', 'learn-gp'])
def test_learning_from_a_recording_twice_is_refused(stream, tmp_path, capsys, command):
    write(tmp_path / 'run1', stream)
    (tmp_path / 'link').symlink_to(tmp_path / 'run1')
    of = ['--robot'] if command == 'identify' else ['--model']
    status = main([command, str(tmp_path / 'run1'), str(tmp_path / 'link'), *of,
                   str(made_of(tmp_path, command)), '--out', str(tmp_path / 'out')])
    assert status == 2 and 'run1 and link: hold the same' in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def made_of(folder, command):
    """Return the robot or model file that a command begins with."""
    if command == 'identify':
        path = folder / 'robot.yaml'
        path.write_text(yaml.safe_dump(four_axes().file.content))
    else:
        path = folder / 'model.yaml'
        write_model(path, model())
    return path


def test_digests_do_not_mind_what_a_message_lacks():
    empty = np.empty(0)
    recording = Recording('x', [JointSample(1.0, (), empty, empty, empty),
                                JointSample(2.0, ('a',), np.array([np.nan]), empty, empty)])
    assert len(set(message_digests(recording))) == 2
