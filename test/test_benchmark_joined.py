"""Several suites in one call, and runs of several calls joined in one table of goals."""

import json
import math
import re

import pytest

from hand_load_estimator import cli
from hand_load_estimator.benchmark import effect_run, joined, offline, run
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.shared_files import share_folder


def test_names_of_suites():
    assert run.suite_names('arms') == ('arms-ur5', 'arms-panda', 'arms-xarm7')
    assert run.suite_names('cold,warm,cold') == ('cold', 'warm')
    assert set(run.suite_names('all')) >= {'base', 'inertia', 'undeclared', 'changes', 'real',
                                           'cost', 'soak', 'arms-panda'}
    assert 'development' not in run.suite_names('all')
    with pytest.raises(ConfigurationError, match='--suite'):
        run.suite_names('base,magic')


def test_the_help_names_every_suite(capsys):
    """Written by hand there: the suites themselves take seconds to import."""
    with pytest.raises(SystemExit):
        cli.main(['benchmark', '--help'])
    (told,) = re.findall(r'--suite NAMES (.*)--robot R.yaml ', capsys.readouterr().out, re.DOTALL)
    for name in (*run.SUITES, 'arms', *run.OTHERS, 'all', effect_run.SUITE):
        assert re.search(rf'\b{name}\b', told), name


@pytest.mark.parametrize(('options', 'match'), [
    (run.Options(methods=('magic',)), '--methods.*bayes'),
    (run.Options(rivals=('magic',)), '--rivals.*figaroh')])
def test_wrong_choices_are_refused_at_once(options, match, tmp_path):
    with pytest.raises(ConfigurationError, match=match):
        run.run_suites('base', options, tmp_path, '')
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(('suites', 'unasked', 'allowed'), [
    ('changes,cost', {'rivals': ('figaroh',)}, 'figaroh.*accuracy suites and real'),
    ('base,arms', {'hours': 2.0}, '2.0.*changes and soak'),
    ('soak', {'data': 'elsewhere'}, 'elsewhere.*real'),
    ('real,cost', {'cases': 8}, '8.*all suites but'),
    ('real', {'learned': 'trained'}, 'trained.*all suites but real')])
def test_what_no_suite_asks_is_refused(suites, unasked, allowed, tmp_path, monkeypatch):
    monkeypatch.setattr(offline, '_identify', lambda name: None)
    (option,) = unasked
    with pytest.raises(ConfigurationError, match=f'--{option}: is not asked by .*{allowed}'):
        run.run_suites(suites, run.Options(**unasked), tmp_path, '')
    assert not list(tmp_path.iterdir())
    # Beside a suite that asks it the others may stand.
    run._refuse_unasked(run.suite_names('all'), run.Options(**unasked))


def run_of(options, commit='abc', command='the command'):
    return run._run(options, command, commit)


def test_several_suites_share_one_table_of_goals(tmp_path, monkeypatch):
    def measure(name, options, out, command, write):
        if name == 'real':
            raise ConfigurationError('--data', 'is not there')
        (out / name).mkdir()
        joined.write_scores(out / name, {'suite': name, 'run': run_of(options)})
        return ''

    monkeypatch.setattr(run, '_measure', measure)
    page = run.run_suites('slow,real', run.Options(), tmp_path, 'the command', lambda text: None)
    assert '| goal (issue 4) |' in page and '[slow](slow/README.md)' in page
    assert 'Not measured: real' in page
    assert '<a href="slow/index.html">slow</a>' in (tmp_path / 'index.html').read_text()
    content = json.loads((tmp_path / 'scores.json').read_text())
    assert [found['folder'] for found in content['runs']] == ['slow']
    assert len(content['goals']) == 23
    with pytest.raises(ConfigurationError, match='--data'):
        run.run_suites('real', run.Options(), tmp_path, 'the command', lambda text: None)


def test_runs_of_other_calls_and_commits_are_joined(tmp_path):
    """Each row and each run tells where it comes from."""
    soak = {'method': 'lstm', 'hours': 24.0, 'flat_memory': True, 'flat_time': True,
            'times_real_time': 9.0, 'growth_mib': 0.3, 'time_drift_percent': 1.0,
            'tail_drift_percent': 1.0, 'load_changes': 0}
    for name, suite, commit, more in (('soak-24h', 'soak', 'abc', soak), ('real', 'real', 'def', {
            'figure': math.nan})):
        (tmp_path / name).mkdir()
        joined.write_scores(tmp_path / name, {
            'suite': suite, 'run': run_of(run.Options(), commit, f'command {name}'), **more})
    (tmp_path / 'effects').mkdir()
    joined.write_scores(tmp_path / 'effects', {'suite': 'effects'})
    page = joined.write_index(tmp_path, run.SCHEMA)
    assert '| yes | [soak-24h](soak-24h/README.md) |' in page
    assert '| [real](real/README.md) | - | def | `command real` |' in page
    assert '2 commits' in page and '[effects]' not in page and 'looking and choosing' not in page
    assert json.loads((tmp_path / 'real' / 'scores.json').read_text())['figure'] is None
    (goal,) = [row for row in json.loads((tmp_path / 'scores.json').read_text())['goals']
               if row['reached']]
    assert goal['runs'] == ['soak-24h']


def test_runs_that_are_no_part_of_one_table_are_refused(tmp_path):
    (tmp_path / 'base').mkdir()
    joined.write_scores(tmp_path / 'base', {'suite': 'base', 'run': run_of(run.Options())})
    joined.refuse_mixture(tmp_path, run_of(run.Options(cases=2000), 'def'))
    for other in (run.Options(development=True), run.Options(robot='ur10e_current')):
        with pytest.raises(ConfigurationError, match='another robot, artefact or seeds'):
            run.run_suites('cold', other, tmp_path, '', lambda text: None)


def test_a_table_on_development_seeds_says_so(tmp_path):
    (tmp_path / 'base').mkdir()
    joined.write_scores(tmp_path / 'base', {
        'suite': 'base', 'run': run_of(run.Options(development=True)), 'scores': {}, 'overview': {
            'cases': 4, 'scored': 3, 'plants': 1}})
    page = joined.write_index(tmp_path, run.SCHEMA)
    assert 'seeds for looking and choosing' in page and '| 3 of 4, 1 plants |' in page


def test_folders_are_named_by_suite_and_choice():
    assert joined.run_name('base') == 'base'
    assert joined.run_name('base', 2000, None, ('lstm',)) == 'base-2000-lstm'
    assert joined.run_name('soak', None, 0.5, ('lstm', 'bayes')) == 'soak-0.5h-lstm+bayes'


def test_the_command_finds_a_shipped_artefact_by_its_name(tmp_path, monkeypatch, capsys):
    asked = []
    monkeypatch.setattr(run, 'run_suites', lambda *args: asked.append(args[1].learned) or '')
    arguments = ['benchmark', '--out', str(tmp_path), '--learned']
    assert cli.main([*arguments, 'ur10e']) == 0
    assert asked == [str(share_folder() / 'config' / 'learned' / 'ur10e')]
    assert cli.main([*arguments, 'ur11']) == 2
    assert 'neither a path nor a shipped file' in capsys.readouterr().err
