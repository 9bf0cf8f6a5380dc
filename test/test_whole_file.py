"""A file appears whole or not at all."""

import os
import threading

import pytest

from hand_load_estimator.files.whole_file import whole_file


def test_the_old_file_stays_until_the_new_one_is_whole(tmp_path):
    path = tmp_path / 'model.yaml'
    path.write_text('old')
    with whole_file(path) as part:
        part.write_text('new')
        assert path.read_text() == 'old' and part.parent == tmp_path
    assert path.read_text() == 'new' and list(tmp_path.iterdir()) == [path]


def test_an_error_leaves_the_old_file_and_nothing_beside_it(tmp_path):
    path = tmp_path / 'model.yaml'
    path.write_text('old')
    with pytest.raises(KeyboardInterrupt), whole_file(path) as part:
        part.write_text('half')
        raise KeyboardInterrupt
    assert path.read_text() == 'old' and list(tmp_path.iterdir()) == [path]


def test_others_may_read_what_a_library_wrote_for_its_owner_only(tmp_path):
    """Who trains an artefact need not be who runs the robot."""
    with whole_file(tmp_path / 'weights') as part:
        part.touch(mode=0o600)
    (tmp_path / 'plain').touch()
    assert (tmp_path / 'weights').stat().st_mode == (tmp_path / 'plain').stat().st_mode


def test_a_pipe_is_written_to_and_stays_one(tmp_path):
    pipe, read = tmp_path / 'pipe', []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()), daemon=True)
    reader.start()
    with whole_file(pipe) as part:
        part.write_text('new')
    reader.join(10.0)
    assert read == ['new'] and pipe.is_fifo() and list(tmp_path.iterdir()) == [pipe]
