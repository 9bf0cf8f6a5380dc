"""Results know their code: by commit, by the sources where there is none, and by both."""

import json
import shutil
import subprocess

import pytest

from hand_load_estimator.benchmark import provenance
from hand_load_estimator.errors import ConfigurationError

KEY = {'suite': 'base', 'commit': 'abc', 'sources': '1f'}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Return the folder of a package of two modules, outside any repository."""
    folder = tmp_path / 'site' / 'package'
    (folder / 'part').mkdir(parents=True)
    (folder / '__init__.py').write_text('A = 1\n')
    (folder / 'part' / 'module.py').write_text('B = 2\n')
    monkeypatch.setattr(provenance, 'PACKAGE', folder)
    monkeypatch.setenv('GIT_CEILING_DIRECTORIES', str(tmp_path))
    return folder


def git(folder, *arguments):
    """Run git in a folder as somebody."""
    subprocess.run(['git', '-c', 'user.name=n', '-c', 'user.email=e', *arguments], cwd=folder,
                   check=True, capture_output=True)


def test_sources_are_content_and_place(package):
    first = provenance.sources()
    (package / 'cache.pyc').write_text('no source')
    assert provenance.sources() == first
    (package / 'part' / 'module.py').write_text('B = 3\n')
    second = provenance.sources()
    (package / 'part' / 'module.py').rename(package / 'module.py')
    assert len({first, second, provenance.sources()}) == 3


def test_without_a_repository_versions_differ_by_their_sources(package):
    first = provenance.commit_now()
    assert first == f'unknown, sources {provenance.sources()[:8]}'
    (package / '__init__.py').write_text('A = 2\n')
    assert provenance.commit_now() != first


@pytest.mark.skipif(not shutil.which('git'), reason='git is not installed')
def test_the_commit_is_the_packages_own(package):
    """One that is only installed below another repository is none of its commits."""
    site = package.parent
    git(site, 'init')
    (site / 'other.txt').write_text('of somebody else')
    git(site, 'add', 'other.txt')
    git(site, 'commit', '-m', 'Other')
    assert provenance.commit_now().startswith('unknown')
    git(site, 'add', '.')
    git(site, 'commit', '-m', 'Ours')
    commit = provenance.commit_now()
    assert len(commit.split()) == 1 and not commit.startswith('unknown')
    (package / '__init__.py').write_text('A = 2\n')
    assert provenance.commit_now().startswith(f'{commit} with changes ')


def test_results_of_another_code_are_refused(tmp_path):
    provenance.same_run(tmp_path, KEY)
    provenance.same_run(tmp_path, KEY)
    assert [path.name for path in tmp_path.iterdir()] == ['key.json']
    for other in ({'commit': 'def'}, {'sources': '2e'}, {'suite': 'cold'}):
        with pytest.raises(ConfigurationError, match='another suite, robot, artefact or commit'):
            provenance.same_run(tmp_path, {**KEY, **other})


def test_a_note_from_before_sources_were_noted_is_told_by_its_commit(tmp_path):
    (tmp_path / 'key.json').write_text(json.dumps({'suite': 'base', 'commit': 'abc'}))
    provenance.same_run(tmp_path, KEY)
    with pytest.raises(ConfigurationError):
        provenance.same_run(tmp_path, {**KEY, 'commit': 'def'})
