"""Suites draw what they say, jobs resume and survive a broken one, arms come from URDFs."""

import json
import math
import os

from core_helpers import four_axes
import numpy as np
import pytest

from hand_load_estimator import cli, seeds
from hand_load_estimator.benchmark import arms, execute, joined, run, suites
from hand_load_estimator.benchmark.suites import cases_of, SUITES, UNDECLARED
from hand_load_estimator.benchmark.wrist_swing import LEAST_ACCELERATION, wrist_swing
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.plant.hidden import EFFECTS
from hand_load_estimator.robot import load_robot
from hand_load_estimator.shared_files import find_shared, share_folder

PLANT = seeds.DEVELOPMENT_PLANTS[95]
CASES = seeds.DEVELOPMENT_CASES[900:940]


def drawn(suite, robot):
    return [SUITES[suite].draw(robot, PLANT, seed) for seed in CASES]


def test_the_base_suite_is_what_it_was():
    """200 cases, 25 plants, 8 each in the order of their seeds: results stay comparable."""
    found = cases_of(SUITES['base'])
    assert [plant for plant, _ in found] == list(seeds.BENCHMARK_PLANTS[:25])
    assert [part for _, part in found] == [
        list(seeds.BENCHMARK_CASES[8 * k:8 * k + 8]) for k in range(25)]


@pytest.mark.parametrize(('count', 'plants'), [(None, 10), (4, 1), (30, 8), (2000, 50)])
def test_cases_are_spread_over_plants(count, plants):
    found = cases_of(SUITES['cold'], count)
    every = [seed for _, part in found for seed in part]
    assert len(every) == len(set(every)) == (count or 40)
    assert len(found) <= plants and len({plant for plant, _ in found}) == len(found)
    assert all(part for _, part in found)
    assert len(found) >= 40 or (count or 40) < 2000


def test_development_never_touches_the_benchmarks_seeds():
    for name, suite in SUITES.items():
        for plant, part in cases_of(suite, 20, development=True):
            assert plant in seeds.DEVELOPMENT_PLANTS, name
            assert all(seed in seeds.DEVELOPMENT_CASES for seed in part), name


def test_cold_and_warm_slow_and_fast_are_the_same_cases_but_for_that():
    robot = four_axes()
    for first, second, what, low, high in (('cold', 'warm', 'temperature', 20.0, 40.0),
                                           ('slow', 'fast', 'speed', 0.45, 0.85)):
        pairs = list(zip(drawn(first, robot), drawn(second, robot)))
        for a, b in pairs:
            np.testing.assert_array_equal(a.load.to_message(), b.load.to_message())
            assert getattr(a, what) <= low and high <= getattr(b, what)
        assert len({getattr(a, what) for a, _ in pairs}) == len(CASES)


def test_loads_of_the_inertia_suite_are_heavy_and_wide():
    robot = load_robot(find_shared('ur10e', 'robots'))
    for case in drawn('inertia', robot):
        assert 6.0 <= case.load.mass <= 10.0 and case.load.is_physical()
        # An ellipsoid's half axis a^2 = 5 (second moment along it) / mass.
        i = case.load.inertia
        second = np.linalg.eigvalsh(0.5 * np.trace(i) * np.eye(3) - i)
        across = 2.0 * np.sqrt(5.0 * second / case.load.mass)
        assert (across >= 0.3 - 1e-9).all() and (across <= 0.4 + 1e-9).all()


@pytest.mark.parametrize('seed', range(3))
def test_wrists_swing_inside_all_limits(seed):
    robot = load_robot(find_shared('ur10e', 'robots'))
    motion = wrist_swing(robot, 6.0, np.random.default_rng(seed))
    q, v, a = motion.sample(np.linspace(0.0, 6.0, 1201))
    assert (np.abs(a).max(axis=0)[-3:] >= LEAST_ACCELERATION).all()
    assert (np.abs(a) <= robot.limits.acceleration).all()
    assert (np.abs(v) <= robot.limits.velocity).all()
    assert ((q >= robot.limits.lower) & (q <= robot.limits.upper)).all()
    torque = np.array([robot.rigid_torque(*row, robot.rated_load) for row in zip(q, v, a)])
    assert (np.abs(torque) <= 0.85 * robot.limits.torque).all()
    np.testing.assert_allclose(v[[0, -1]], 0.0, atol=1e-12)


def test_wrists_that_cannot_swing_are_refused():
    content = {**four_axes().file.content}
    content['max_acceleration'] = [2.0] * 4
    from hand_load_estimator.robot import robot_from_content
    with pytest.raises(ConfigurationError, match='swings the rated load'):
        wrist_swing(robot_from_content(content, 'slow'), 3.0, np.random.default_rng(0))


def test_undeclared_effects_take_turns_at_strength_two():
    robot = four_axes()
    seed = next(s for s in CASES if UNDECLARED[s % len(UNDECLARED)] == 'torque_offset')
    case = SUITES['undeclared'].draw(robot, PLANT, seed)
    (entry,) = case.hidden
    assert entry['name'] == 'torque_offset' and entry['strength'] == 2.0
    assert len(entry['joints']) == 1
    drawn = {UNDECLARED[s % len(UNDECLARED)] for s in CASES}
    assert drawn == set(EFFECTS) - {'load_change'}


def test_every_effect_has_four_cases_on_four_plants(monkeypatch):
    """Of the cases as drawn; every joint can have every effect, which takes long to find out."""
    monkeypatch.setattr(suites, 'place', lambda robot, case: [{'name': case.hidden[0].name}])
    robot, plants = four_axes(), {}
    for plant, part in cases_of(SUITES['undeclared']):
        for seed in part:
            (entry,) = SUITES['undeclared'].draw(robot, plant, seed).hidden
            plants.setdefault(entry['name'], []).append(plant)
    assert set(plants) == set(EFFECTS) - {'load_change'}
    assert all(len(own) == len(set(own)) == 4 for own in plants.values())


def test_where_no_joint_can_have_an_effect_the_next_one_is_hidden(monkeypatch):
    robot, names = four_axes(), list(UNDECLARED)
    seed = next(s for s in CASES if names[s % len(names)] == 'torque_offset')
    place = suites.place

    def without(refused):
        def placed(robot, case):
            if case.hidden[0].name in refused:
                raise ConfigurationError('plant', 'cannot')
            return place(robot, case)
        return placed

    last = names.index('torque_offset')
    monkeypatch.setattr(suites, 'place', without(names[last:]))
    (entry,) = SUITES['undeclared'].draw(robot, PLANT, seed).hidden
    assert entry['name'] in names[:last]
    monkeypatch.setattr(suites, 'place', without(names))
    with pytest.raises(ConfigurationError, match='no effect so strong'):
        SUITES['undeclared'].draw(robot, PLANT, seed)


# Running jobs.

def test_jobs_are_stored_and_read_again(tmp_path):
    jobs = {f'n{k}': (k,) for k in (1, 4)}
    first = execute.measure_all(math.sqrt, jobs, tmp_path, workers=0)
    assert first == {'n1': 1.0, 'n4': 2.0}
    (tmp_path / 'n1.json').write_text('"kept"')
    assert execute.measure_all(math.sqrt, jobs, tmp_path, workers=0)['n1'] == 'kept'


def test_a_broken_job_is_told_and_left_out(tmp_path):
    told = []
    found = execute.measure_all(math.sqrt, {f'n{k}': (k,) for k in (4, -1)}, tmp_path, 1,
                                write=told.append)
    assert found == {'n4': 2.0}
    assert any('n-1 failed: ValueError' in line for line in told)
    assert [path.name for path in tmp_path.iterdir()] == ['n4.json']
    with pytest.raises(ValueError):
        execute.measure_all(math.sqrt, {'n-1': (-1,)}, tmp_path, workers=0)


def test_a_cluster_gives_its_results_to_this_process(tmp_path, monkeypatch):
    """joblib's loky stands for it: the workers write nothing, and all of them are used."""
    joblib = pytest.importorskip('joblib', reason='joblib is not installed: no cluster to test')
    asked, kept = [], execute._keep
    monkeypatch.setattr(execute, '_keep', lambda *given: asked.append(os.getpid()) or kept(*given))
    given, config = [], joblib.parallel_config
    monkeypatch.setattr(joblib, 'parallel_config', lambda **told: given.append(told) or config(
        **{**told, 'n_jobs': 2}))
    told, jobs = [], {f'n{k}': (k,) for k in (4, -1, 9)}
    found = execute.measure_all(math.sqrt, jobs, tmp_path, backend='loky', write=told.append)
    assert found == {'n4': 2.0, 'n9': 3.0} and asked == [os.getpid()] * 2
    assert given == [{'backend': 'loky', 'n_jobs': -1}]
    assert any('n-1 failed: ValueError' in line for line in told)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['n4.json', 'n9.json']
    # What is there is not measured again, and what failed is tried.
    (tmp_path / 'n9.json').write_text('"kept"')
    jobs['n-1'] = (16,)
    found = execute.measure_all(math.sqrt, jobs, tmp_path, 2, 'loky', told.append)
    assert found == {'n4': 2.0, 'n-1': 4.0, 'n9': 'kept'} and len(asked) == 3


def test_a_cluster_needs_joblib(tmp_path, monkeypatch):
    import sys
    monkeypatch.setitem(sys.modules, 'joblib', None)
    with pytest.raises(ConfigurationError, match='--backend.*joblib'):
        execute.measure_all(math.sqrt, {'n1': (1,)}, tmp_path, 1, 'dask', lambda text: None)


# Arms.

def test_an_arms_file_is_the_draft_filled_in(tmp_path, monkeypatch):
    urdf = tmp_path / 'small.urdf'
    urdf.write_text(four_axes().file.urdf)
    own = four_axes()
    monkeypatch.setitem(arms.ARMS, 'small', arms.ExtraArm(
        str(urdf), own.load_frame, 'link_torque', 2.0, 0.1, (5.0,) * 4, 'made up'))
    robot = load_robot(arms.write_arm('small', urdf, tmp_path / 'robots'))
    assert robot.joints == own.joints and robot.effort.kind == 'link_torque'
    assert robot.rated_load.mass == 2.0 and robot.limits.acceleration.tolist() == [5.0] * 4
    assert 'sensors behind the gears' in arms.friction_told(robot)
    assert 'Coulomb' in arms.friction_told(own)


@pytest.mark.parametrize('name', arms.ARMS)
def test_the_extra_arms_can_be_simulated(name, tmp_path):
    from hand_load_estimator.benchmark.cases import simulated
    from hand_load_estimator.simulate_motions import named_motion
    try:
        urdf = arms.urdf_of(arms.ARMS[name])
    except ConfigurationError:
        pytest.skip(f'{arms.PACKAGE} is not installed')
    robot = load_robot(arms.write_arm(name, urdf, tmp_path))
    assert robot.n == {'ur5': 6}.get(name, 7)
    motion = named_motion('pick_place', robot, 4.0, 1.0, 3)
    samples = simulated(robot, motion, seed=PLANT, load=robot.rated_load)
    assert len(samples) > 50
    assert max(np.abs(s.v).max() for s in samples) > 0.1
    effort = np.array([s.effort for s in samples])
    assert np.isfinite(effort).all() and (np.abs(effort) <= robot.limits.torque).all()


def test_arms_need_their_package(monkeypatch):
    monkeypatch.setattr(arms, 'PACKAGE', 'no-such-package')
    with pytest.raises(ConfigurationError, match='arms needs the package'):
        arms.urdf_of(arms.ARMS['ur5'])


# Several suites.

def test_names_of_suites():
    assert run.suite_names('arms') == ('arms-ur5', 'arms-panda', 'arms-xarm7')
    assert run.suite_names('cold,warm,cold') == ('cold', 'warm')
    assert set(run.suite_names('all')) >= {'base', 'inertia', 'undeclared', 'changes', 'real',
                                           'cost', 'soak', 'arms-panda'}
    assert 'development' not in run.suite_names('all')
    with pytest.raises(ConfigurationError, match='--suite'):
        run.suite_names('base,magic')


@pytest.mark.parametrize(('options', 'match'), [
    (run.Options(methods=('magic',)), '--methods.*bayes'),
    (run.Options(rivals=('magic',)), '--rivals.*figaroh')])
def test_wrong_choices_are_refused_at_once(options, match, tmp_path):
    with pytest.raises(ConfigurationError, match=match):
        run.run_suites('base', options, tmp_path, '')
    assert not list(tmp_path.iterdir())


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
    assert len(content['goals']) == 21
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
