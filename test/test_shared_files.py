"""Short names of shipped files, and paths."""

import pytest

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.shared_files import find_shared, share_folder

SHIPPED = share_folder() / 'config'


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Return an empty folder to be in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_folder_of_the_same_name_does_not_hide_a_shipped_file(here):
    (here / 'ur10e').mkdir()
    assert find_shared('ur10e', 'robots') == SHIPPED / 'robots' / 'ur10e.yaml'
    assert find_shared('./ur10e', 'robots').samefile(here / 'ur10e')
    assert find_shared(here / 'ur10e', 'robots') == here / 'ur10e'


@pytest.mark.parametrize('name, kind', [('ur10e.yaml', 'robots'), ('ur10e.yaml', 'models'),
                                        ('plant.yaml', 'robots'), ('ur10e', 'robots')])
def test_a_file_of_ones_own_comes_first(here, name, kind):
    (here / name).touch()
    assert find_shared(name, kind).samefile(here / name)


@pytest.mark.parametrize('name', ['learned', 'ur10e_gru'])
def test_an_artefact_of_ones_own_comes_first(here, name):
    (here / name).mkdir()
    assert find_shared(name, 'learned').samefile(here / name)


def test_the_home_of_a_user_whom_nobody_knows_is_no_path():
    with pytest.raises(ConfigurationError, match='neither a path nor a shipped file'):
        find_shared('~no_such_user/arm.yaml', 'robots')


def test_short_names_are_those_of_shipped_files(here):
    assert find_shared('ur10e_gru', 'learned') == SHIPPED / 'learned' / 'ur10e_gru'
    with pytest.raises(ConfigurationError, match='one of ur10e, ur10e_current'):
        find_shared('ur5', 'robots')
