"""Short names of shipped files, and paths."""

import pytest

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.shared_files import find_shared, share_folder


def test_a_folder_of_the_same_name_does_not_hide_a_shipped_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'ur10e').mkdir()
    shipped = share_folder() / 'config'
    assert find_shared('ur10e', 'robots') == shipped / 'robots' / 'ur10e.yaml'
    assert find_shared('ur10e_gru', 'learned') == shipped / 'learned' / 'ur10e_gru'
    assert find_shared('./ur10e', 'robots').samefile(tmp_path / 'ur10e')
    assert find_shared(tmp_path / 'ur10e', 'learned') == tmp_path / 'ur10e'


def test_what_is_neither_is_refused_with_the_names_there_are():
    with pytest.raises(ConfigurationError, match='one of ur10e, ur10e_current'):
        find_shared('ur5', 'robots')
