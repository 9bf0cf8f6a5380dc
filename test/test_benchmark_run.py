"""Runs of the benchmark: from plant to result, kept and resumed, written to pages."""

from dataclasses import replace
import json

from benchmark_helpers import result
from core_helpers import exact_model, four_axes
import numpy as np
import pytest
import yaml

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import cases, measure, run
from hand_load_estimator.benchmark.contestants import OUR_MODEL, REGRESSOR
from hand_load_estimator.benchmark.execute import stored
from hand_load_estimator.benchmark.measure import (measure_plant, plant_models, robot_and_models,
                                                   run_case)
from hand_load_estimator.benchmark.scores import complete
from hand_load_estimator.benchmark.suites import SUITES
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.learning import (bayesian_network, distilled_network, left_out,
                                          neural_process, torque_gp)
from hand_load_estimator.load import LoadParameters


def broken(*_):
    raise RuntimeError('measured again')


def test_what_is_there_is_kept(tmp_path):
    path = tmp_path / 'plant_1234.json'
    path.write_text('[]')
    assert stored(broken, 'plant_1234', (), tmp_path) == []
    assert path.read_text() == '[]'
    with pytest.raises(RuntimeError):
        stored(broken, 'plant_1235', (), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ['plant_1234.json']


def test_an_unknown_suite_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match='--suite.*magic.*base'):
        run.run_suites('magic', run.Options(), tmp_path, '')


def test_a_suite_writes_its_pages_and_resumes(tmp_path, monkeypatch):
    """Plants measured before are read, not measured again."""
    plants = seeds.BENCHMARK_PLANTS[:2]
    monkeypatch.setattr(run, 'commit_now', lambda: 'abc')
    monkeypatch.setattr(run, 'measure_plant', broken)
    folder = tmp_path / 'base-8-bayes'
    (folder / 'raw').mkdir(parents=True)
    for k, plant in enumerate(plants):
        (folder / 'raw' / f'plant_{plant}.json').write_text(
            json.dumps([result(plant, k, off=0.1)]))
    options = run.Options(cases=8, methods=('bayes',), workers=0)
    page = run.run_suites('base', options, tmp_path, 'the command', lambda text: None)
    assert 'the command' in page and '2 of 2 cases from 2 plants' in page
    assert (folder / 'README.md').read_text() == page
    assert '<img src="data:image/svg+xml' in (folder / 'index.html').read_text()
    content = json.loads((folder / 'scores.json').read_text())
    assert content['schema'] == 'hand_load/benchmark/1'
    assert content['scores']['bayes'][0]['mass']['rmse'] == pytest.approx(0.1)
    assert (folder / 'mass.png').stat().st_size > 5000
    assert '| [base-8-bayes](base-8-bayes/README.md) | 2 of 2, 2 plants | abc | `the command` |' \
        in (tmp_path / 'README.md').read_text()
    monkeypatch.setattr(run, 'commit_now', lambda: 'def')
    with pytest.raises(ConfigurationError, match='another suite, robot, artefact or commit'):
        run.run_suites('base', options, tmp_path, 'the command', lambda text: None)


def test_a_small_case_from_plant_to_result(tmp_path, monkeypatch):
    """One plant of a small arm with brief recordings: right, resumable, in the stated form."""
    brief = cases.Recorded((('excite', 20.0, 8.0), ('pick_place', 30.0, 6.0)))
    monkeypatch.setitem(SUITES, 'base', replace(SUITES['base'], recorded=brief))
    monkeypatch.setattr(cases, 'DURATION', 5.0)
    monkeypatch.setattr(measure, 'TIMES', (0.5, 1.0))
    for module in (bayesian_network, distilled_network, neural_process, torque_gp):
        monkeypatch.setattr(module, 'STEPS', 30)
    # Of what so little teaches next to nothing counts; subtracted whole, each function shows.
    monkeypatch.setattr(left_out, '_gain', lambda data, mean, rows: np.ones(mean.shape[1]))
    robot_path = tmp_path / 'arm.yaml'
    robot_path.write_text(yaml.safe_dump(four_axes().file.content))
    plant, seed = seeds.DEVELOPMENT_PLANTS[90], seeds.DEVELOPMENT_CASES[995]
    arguments = 'base', str(robot_path), plant, [seed], None, None, ()
    stored(measure_plant, 'plant', arguments, tmp_path)
    robot_and_models.cache_clear()
    (found,) = json.loads((tmp_path / 'plant.json').read_text())
    assert not list(tmp_path.glob('*.part'))
    assert found['plant'] == plant and found['seed'] == seed and len(found['bound']) == 3
    truth = np.array(found['load'])
    for name, rows in found['methods'].items():
        assert np.array(rows).shape == (3, 2, 10), name
    mean, std = np.array(found['methods']['bayes'][-1])
    assert abs(mean[0] - truth[0]) < 4.0 * std[0] and std[0] < 0.3
    error = {name: abs(rows[-1][0][0] - truth[0]) for name, rows in found['methods'].items()}
    assert error['bayes'] < 0.3 * error['fixed rated load']
    assert error[OUR_MODEL] < 0.3 * error['fixed rated load']
    assert (std[0] > np.array(found['bound'])[-1, 0])
    over = np.array(found['bound_start_unknown']) / found['bound']
    assert over.shape == (3, 10) and (over >= 1.0).all() and over[0, 0] > over[-1, 0]
    assert all(value > 0.0 for value in found['seconds_per_sample'].values())
    assert set(found['cost']) == {*found['methods'], REGRESSOR}
    assert all(0.0 < c['p50'] <= c['p99'] for c in found['cost'].values())
    # E2.5, E2.6: each function answers for itself.
    on_functions = [tuple(found['methods'][name][-1][0]) for name in (
        'gp_bayes', 'gp_bayes_neural_process', 'gp_bayes_distilled',
        'gp_bayes_bayesian_network', 'gp_bayes_known_load')]
    assert len(set(on_functions)) == 5
    # No artefact belongs to this arm: what would fall back on bayes is not shown beside it.
    assert 'lstm' not in found['methods']


def test_models_of_a_plant_are_ours_the_textbooks_and_the_nominal():
    models = plant_models(four_axes(), seeds.DEVELOPMENT_PLANTS[91],
                          recorded=cases.Recorded((('excite', 20.0, 10.0),)))
    names = {key: {use.name for use in model.uses} for key, model in models.items()}
    assert names['nominal'] == set()
    assert names['textbook'] == {'rotor_inertia', 'coulomb_friction', 'viscous_friction',
                                 'torque_offset'}
    assert names['textbook'] < names['ours']
    np.testing.assert_array_equal(models['nominal'].mean, four_axes().nominal_links)


def test_where_temperatures_are_not_told_nobody_sees_them(monkeypatch):
    monkeypatch.setattr(cases, 'DURATION', 1.0)
    robot, plant = four_axes(), seeds.DEVELOPMENT_PLANTS[93]
    recorded = cases.Recorded((('pick_place', 25.0, 8.0),), told=False)
    models = plant_models(robot, plant, recorded=recorded)
    assert models['ours'].temperatures is None and len(models['ours'].recordings) == 1
    assert not any('temperature' in use.name for use in models['ours'].uses)
    seen, update = [], measure.RegressorClock.update
    monkeypatch.setattr(measure.RegressorClock, 'update',
                        lambda clock, sample: seen.append(sample) or update(clock, sample))
    case = cases.Case(plant, 1, LoadParameters(), 20.0, 1.0)
    for told in (False, True):
        seen.clear()
        run_case(robot, case, models, None, ('bayes',), told=told)
        assert len(seen) > 10
        assert all(np.isfinite(sample.temperature).all() == told for sample in seen)


def test_run_case_of_an_arm_that_hardly_moves_is_incomplete(monkeypatch):
    monkeypatch.setattr(cases, 'DURATION', 0.5)
    robot = four_axes()
    model = exact_model('four')
    case = cases.Case(seeds.DEVELOPMENT_PLANTS[92], 1, LoadParameters(), 20.0, 0.3)
    found = run_case(robot, case, {'ours': model, 'textbook': model, 'nominal': model}, None,
                     ('lstm', 'bayes'))
    assert not complete([found])
