"""The benchmark's own figures: exact on results made by hand, a bound that is one, resuming."""

from dataclasses import replace
import json

from core_helpers import block, exact_model, four_axes, messages
import numpy as np
import pytest
import yaml

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import cases, measure, run
from hand_load_estimator.benchmark.bound import Bound
from hand_load_estimator.benchmark.contestants import Contestant, OUR_MODEL, REGRESSOR
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.execute import stored
from hand_load_estimator.benchmark.measure import (measure_plant, MOMENTS, plant_models,
                                                   robot_and_models, run_case)
from hand_load_estimator.benchmark.page import suite_blocks
from hand_load_estimator.benchmark.rivals import FixedLoad, LeastSquares
from hand_load_estimator.benchmark.scores import complete, overview, score, verdicts
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.identification import nominal_model
from hand_load_estimator.learning import bayesian_network, distilled_network, neural_process
from hand_load_estimator.load import (LoadParameters, message_from_products, MESSAGE_ORDER,
                                      products_from_shape, products_jacobian_of_shape)
from hand_load_estimator.model_follower import Prediction
from hand_load_estimator.motion import MotionSample
from hand_load_estimator.plant import JointEvent, TemperatureEvent
from hand_load_estimator.recording import JointSample
from hand_load_estimator.robot import load_robot
from hand_load_estimator.shared_files import find_shared

METHODS = ('lstm', 'bayes', 'least squares')


def result(plant, seed, mass=5.0, off=0.0, std=1.0, bound=0.5, times=len(MOMENTS), changes=0):
    """Return a case in which every figure is off by `off` standard figures."""
    load = block(mass).to_message()
    row = [(load + off).tolist(), [std] * 10]
    return {'plant': plant, 'seed': seed, 'load': load.tolist(), 'temperature': 20.0,
            'speed': 1.0, 'bound': [[bound] * 10] * times, 'changes': changes,
            'methods': {name: [row] * times for name in METHODS},
            'seconds_per_sample': dict.fromkeys(METHODS, 1e-3 * seed)}


def test_rmse_median_and_percentile_are_exact():
    offs = [0.0, 0.3, -0.4, 1.2]
    out = score([result(k, k, off=off) for k, off in enumerate(offs)], 12.5)
    assert set(out) == set(METHODS)
    assert [entry['time'] for entry in out['bayes']] == list(MOMENTS)
    for entry in out['bayes']:
        assert entry['mass']['rmse'] == pytest.approx(np.sqrt(np.mean(np.square(offs))))
        assert entry['mass']['median'] == pytest.approx(0.35)
        assert entry['mass']['p95'] == pytest.approx(np.quantile([0.0, 0.3, 0.4, 1.2], 0.95))
        assert entry['mass_percent_of_rated']['rmse'] \
            == pytest.approx(100.0 * entry['mass']['rmse'] / 12.5)
        # The centre of mass is a distance in space: sqrt(3) of what each axis is off.
        assert entry['com']['p95'] == pytest.approx(np.sqrt(3) * entry['mass']['p95'])
        assert entry['inertia']['izz']['rmse'] == pytest.approx(entry['mass']['rmse'])
        assert entry['bound_mass_rmse'] == pytest.approx(0.5)
        assert entry['width_over_bound']['m'] == pytest.approx(2.0)


def test_coverage_is_counted_within_1_96_and_clustered_by_plant():
    """Plants of 4 cases each: one covers all, one none, one half."""
    offs = [0.0, 1.9, -1.9, 1.95, 2.0, -2.0, 3.0, 9.0, 0.0, 0.0, 2.5, 2.5]
    out = score([result(k // 4, k, off=off) for k, off in enumerate(offs)], 12.5)
    for entry in out['lstm']:
        assert set(entry['coverage']) == set(MESSAGE_ORDER)
        for figures in entry['coverage'].values():
            assert figures['share'] == pytest.approx(0.5)
            assert figures['error'] == pytest.approx(np.std([1, 0, 0.5], ddof=1) / np.sqrt(3))


def test_place_is_scored_where_there_is_something_to_place():
    light, heavy = result(0, 0, mass=0.5, off=1.0), result(1, 1, mass=5.0, off=0.1)
    out = score([light, heavy], 12.5)
    assert out['bayes'][0]['com']['rmse'] == pytest.approx(np.sqrt(3) * 0.1)


def test_goals_are_judged_on_the_figures():
    near = {what: (value, good) for what, _, value, good in verdicts(
        score([result(k, k, off=0.1) for k in range(3)], 12.5))}
    assert near['median mass error at 1 s, % of rated'] == ('0.80', True)
    assert near['95th percentile at 10 s, % of rated'] == ('0.80', False)
    assert near['better baseline over ours, mass RMSE at 1 s'] == ('1.0', False)
    for when in ('over all times', 'at every single time'):
        assert near[f'coverage of every parameter {when}, %'] == ('100.0 to 100.0', False)


def test_coverage_over_all_times_may_be_right_where_single_times_are_not():
    # One case of 20 misses everything; four more miss the mass once, at the fourth moment.
    results = [result(k, k, off=9.0 if k == 0 else 0.1) for k in range(20)]
    for case in results[1:5]:
        case['methods'] = json.loads(json.dumps(case['methods']))
        case['methods']['lstm'][3][0][0] += 100.0
    near = {what: (value, good) for what, _, value, good in verdicts(score(results, 12.5))}
    assert near['coverage of every parameter over all times, %'] == ('92.1 to 95.0', True)
    assert near['coverage of every parameter at every single time, %'] == ('75.0 to 95.0', False)


def test_cases_that_moved_too_briefly_are_counted_and_not_scored():
    results = [result(0, 1), result(0, 2, times=3), result(1, 3, off=1.0, changes=2)]
    assert [r['seed'] for r in complete(results)] == [1, 3]
    counts = overview(results)
    assert (counts['cases'], counts['scored'], counts['plants']) == (3, 2, 2)
    assert counts['false_load_changes'] == 1
    assert counts['microseconds_per_sample']['bayes'] == pytest.approx(2000.0)


def test_the_page_shows_what_was_measured():
    results = [result(k, k, off=0.25) for k in range(3)]
    scores = score(results, 12.5)
    content = {'scores': scores, 'overview': overview(results), 'failed': 2,
               'fell_back': ['gru']}
    page = to_markdown(suite_blocks('Accuracy', 'all sorts', content, verdicts(scores),
                                    'hand_load benchmark', 'abc1234'))
    assert '3 of 3 cases from 3 plants' in page and 'abc1234' in page and 'all sorts' in page
    assert '2 plants could not be measured' in page and '`gru` would run as `bayes`' in page
    assert '| lstm | 250 |' in page and 'Cramer-Rao bound' in page


def test_the_page_tells_every_methods_coverage_in_a_row():
    """Half the cases of `gru` leave the mass's interval at every time, those of `lstm` none."""
    results = [result(k, k) for k in range(4)]
    for k, found in enumerate(results):
        rows = found['methods']['lstm']
        away = np.r_[5.0 * (k % 2), np.zeros(9)]
        found['methods'] = {name: [[(np.array(mean) + off).tolist(), std] for mean, std in rows]
                            for name, off in (('lstm', 0.0), ('gru', away), ('rival', away))}
        found['seconds_per_sample'] = dict.fromkeys(found['methods'], 1e-3)
    page = to_markdown(suite_blocks('Accuracy', '', {'scores': score(results, 12.5),
                                                     'overview': overview(results)}, (), '', ''))
    first = MESSAGE_ORDER[0]
    assert f'| lstm | 100.0 | 100.0 ({first}) | 100.0 ({first}) |' in page
    assert f'| gru | 95.0 | 50.0 ({first}) | 100.0 (' in page
    assert '| rival | 95.0' not in page


# The bound.

def bounds(mass=2.0, noise=0.3, seconds=3.0):
    """Return the bound's stds (N, 10) along a motion of a small arm."""
    robot = four_axes()
    bound, out = Bound(robot, block(mass), np.full(4, noise), 500.0), []
    for m in messages(exact_model('four'), block(mass), seconds, rate=50.0, noisy=False):
        bound.update(MotionSample(m.stamp, 0.02, m.position, m.velocity, np.zeros(4), m.effort,
                                  np.zeros(4), False))
        out.append(bound.std())
    return np.array(out)


def test_the_bound_never_rises_and_begins_below_the_prior():
    stds = bounds()
    assert (np.diff(stds, axis=0) <= 1e-12).all()
    assert (stds[0, :4] <= load_prior(four_axes()).std[:4] * (1 + 1e-9)).all()
    assert (stds[-1, :4] < 0.2 * stds[0, :4]).all()


def test_the_bound_is_in_proportion_to_the_noise_once_data_rule():
    few, many = bounds(noise=0.01)[-1], bounds(noise=0.02)[-1]
    np.testing.assert_allclose(many[:4] / few[:4], 2.0, rtol=0.02)


def test_the_bound_is_the_spread_of_the_best_estimate():
    """Least squares with exact model and noise cannot do better, and does as well."""
    robot, rng, sigma = four_axes(), np.random.default_rng(1), 0.05
    stream = messages(exact_model('four'), block(2.0), 3.0, rate=50.0, noisy=False)
    k = np.array([robot.load_regressor(m.position, m.velocity, np.zeros(4)) for m in stream])
    rows = k.reshape(-1, 10)
    bound = Bound(robot, block(2.0), np.full(4, sigma), 50.0)
    for m in stream:
        bound.update(MotionSample(m.stamp, 0.02, m.position, m.velocity, np.zeros(4), m.effort,
                                  np.zeros(4), False))
    shape = block(2.0).to_message() / np.r_[1.0, 1.0, 1.0, 1.0, np.full(6, 2.0)]
    jacobian = products_jacobian_of_shape(shape)
    precision = np.diag(load_prior(robot).std ** -2.0)
    a = rows @ jacobian / sigma
    gain = np.linalg.inv(a.T @ a + precision)
    errors = []
    for _ in range(400):
        prior = load_prior(robot).std * rng.normal(size=10)
        noise = rng.normal(size=len(rows))
        errors.append(gain @ (a.T @ noise + precision @ prior))
    spread = np.std(errors, axis=0)
    np.testing.assert_allclose(bound.std()[:4], spread[:4], rtol=0.15)


# The rivals.

def test_recursive_least_squares_is_the_batch_solution():
    model, rng = nominal_model(four_axes(), np.full(4, 0.02)), np.random.default_rng(2)
    rival, prior = LeastSquares(model, skip_standing=False), load_prior(model.robot)
    variance, load = model.residuals.rmse ** 2, block(2.0).to_products()
    jacobian = products_jacobian_of_shape(prior.mean)
    information = np.linalg.inv(jacobian @ np.diag(prior.std ** 2) @ jacobian.T)
    vector, zero = information @ products_from_shape(prior.mean), np.zeros(4)
    for k in range(40):
        columns = model.robot.load_regressor(*rng.uniform(-1.5, 1.5, (3, 4)))
        torque = columns @ load + np.sqrt(variance) * rng.normal(size=4)
        belief = rival.update(
            MotionSample(0.02 * k, 0.02, zero, zero, zero, zero, zero, False),
            Prediction(torque, columns, np.zeros((4, 0)), zero, zero, zero, zero + 1.0,
                       np.zeros(0)))
        information += (columns / variance[:, None]).T @ columns
        vector += (columns / variance[:, None]).T @ torque
    batch = message_from_products(np.linalg.solve(information, vector))
    np.testing.assert_allclose(belief.mean[:4], batch[:4], atol=1e-6)
    assert np.sqrt(belief.covariance[0, 0]) == pytest.approx(
        np.sqrt(np.linalg.inv(information)[0, 0]), rel=1e-4)


def test_the_careful_rival_leaves_out_what_stands():
    model, zero = nominal_model(four_axes(), np.full(4, 0.02)), np.zeros(4)
    columns = model.robot.load_regressor(np.full(4, 0.4), zero, zero)
    prediction = Prediction(columns @ block(2.0).to_products(), columns, np.zeros((4, 0)), zero,
                            zero, zero, zero + 1.0, np.zeros(0))
    still = MotionSample(0.0, 0.02, zero, zero, zero, zero, zero, False)
    careful, naive = (LeastSquares(model, skip) for skip in (True, False))
    before = careful.belief().mean
    np.testing.assert_array_equal(careful.update(still, prediction).mean, before)
    assert abs(naive.update(still, prediction).mean[0] - before[0]) > 0.01


def test_the_fixed_load_never_learns():
    robot = four_axes()
    belief = FixedLoad(robot).update(None, None)
    np.testing.assert_array_equal(belief.mean, robot.rated_load.to_message())


# Cases and runs.

class Lighter:
    """A method that believes in a little less than nothing."""

    def update(self, sample, prediction):
        return Belief(np.concatenate([[-0.01], np.zeros(9)]), 1e-4 * np.eye(10))


class OurLighter(Lighter):
    tared = np.zeros(10)


def test_ours_are_judged_as_they_are_published_and_rivals_as_they_are():
    ours, rival = (Contestant(None, lambda _, m=m: m()) for m in (OurLighter, Lighter))
    assert ours.update(None).mean[0] >= 0.0 > rival.update(None).mean[0]


def test_a_case_belongs_to_its_seed_and_is_a_body():
    robot = four_axes()
    drawn = [cases.draw_case(robot, 1000, seed) for seed in range(50)]
    again = cases.draw_case(robot, 1000, 7)
    np.testing.assert_array_equal(again.load.to_message(), drawn[7].load.to_message())
    assert all(case.load.is_physical() for case in drawn)
    masses = [case.load.mass for case in drawn]
    heaviest = 10.0 / 12.5 * robot.rated_load.mass
    assert 0.8 * heaviest < max(masses) <= heaviest and min(masses) < 0.2 * heaviest
    assert {0.3 <= case.speed <= 1.0 and 15.0 <= case.temperature <= 50.0 for case in drawn} \
        == {True}


def test_motion_start_is_the_first_move_of_a_joint_that_gravity_loads():
    """Joint 1 turns about the vertical and tells nothing of the load's weight."""
    robot, zero, q = four_axes(), np.zeros(4), np.array([0.0, 0.8, 0.3, 0.2])

    def sample(t, v):
        return JointEvent(t, q, np.array(v), zero)

    # A chain whose first axis is upright only roughly: take what gravity really loads.
    torque = np.abs(robot.load_regressor(q, zero, zero) @ robot.rated_load.to_products())
    loaded = int(np.argmax(torque))
    free = [j for j in range(4) if torque[j] < 0.1 * torque.max()]
    slow, fast = np.eye(4)[loaded] * 0.04, np.eye(4)[loaded] * 0.06
    samples = [TemperatureEvent(0.0, zero), sample(0.0, zero), sample(0.1, slow),
               sample(0.3, fast)]
    for j in free:
        samples.insert(2, sample(0.05, np.eye(4)[j]))
    assert cases.motion_start(robot, samples) == 0.3
    assert cases.motion_start(robot, samples[:-1]) is None


@pytest.mark.parametrize('joint', range(6))
def test_the_clock_of_a_six_axis_arm_starts_with_joints_two_to_four(joint):
    """Wrist 2 carries weight in most poses, and starts no clock (DESIGN section 6)."""
    robot = load_robot(find_shared('ur10e', 'robots'))
    q, zero = np.array([0.0, -1.2, 1.5, 0.4, 0.6, 0.3]), np.zeros(6)
    moving = JointEvent(0.2, q, 0.06 * np.eye(6)[joint], zero)
    start = cases.motion_start(robot, [JointEvent(0.0, q, zero, zero), moving])
    assert start == (0.2 if 1 <= joint <= 3 else None)
    if joint == 4:
        assert robot.gravity_loaded(q)[joint]


def test_the_clock_starts_with_what_is_measured_and_not_with_the_filter():
    robot = load_robot(find_shared('ur10e', 'robots'))
    case = cases.draw_case(robot, seeds.DEVELOPMENT_PLANTS[93], seeds.DEVELOPMENT_CASES[996])
    events = list(cases.case_events(robot, case))
    run = cases.case_run(robot, case)
    states = [e for e in events if isinstance(e, JointEvent)]
    first = next(e for e in states if (np.abs(e.velocity[1:4]) > cases.MOTION_START).any())
    filtered = next(s for s in run.samples if (np.abs(s.v[1:4]) > cases.MOTION_START).any())
    assert run.start == first.stamp < filtered.stamp - 0.02


def test_the_clock_reads_recordings_by_joint_names():
    robot = load_robot(find_shared('ur10e', 'robots'))
    q = np.array([0.0, -1.2, 1.5, 0.4, 0.6, 0.3])
    names, velocity = tuple(reversed(robot.joints)), 0.06 * np.eye(6)[2]
    rows = [JointSample(stamp, names, q[::-1], v[::-1], np.zeros(6))
            for stamp, v in ((1.0, 0 * velocity), (1.01, velocity))]
    assert cases.motion_start(robot, rows) == 1.01
    assert cases.motion_start(robot, [replace(row, velocity=np.array([])) for row in rows]) is None


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
    monkeypatch.setattr(cases, 'IDENTIFICATION', (('excite', 20.0, 12.0),
                                                  ('pick_place', 30.0, 8.0)))
    monkeypatch.setattr(cases, 'DURATION', 5.0)
    monkeypatch.setattr(measure, 'TIMES', (0.5, 1.0))
    for module in (bayesian_network, distilled_network, neural_process):
        monkeypatch.setattr(module, 'STEPS', 30)
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
    assert all(value > 0.0 for value in found['seconds_per_sample'].values())
    assert set(found['cost']) == {*found['methods'], REGRESSOR}
    assert all(0.0 < c['p50'] <= c['p99'] for c in found['cost'].values())
    # E2.6: each function answers for itself.
    on_functions = [tuple(found['methods'][name][-1][0]) for name in (
        'gp_bayes', 'gp_bayes_neural_process', 'gp_bayes_distilled',
        'gp_bayes_bayesian_network')]
    assert len(set(on_functions)) == 4
    # No artefact belongs to this arm: what would fall back on bayes is not shown beside it.
    assert 'lstm' not in found['methods']


def test_models_of_a_plant_are_ours_the_textbooks_and_the_nominal(monkeypatch):
    monkeypatch.setattr(cases, 'IDENTIFICATION', (('excite', 20.0, 10.0),))
    models = plant_models(four_axes(), seeds.DEVELOPMENT_PLANTS[91])
    names = {key: {use.name for use in model.uses} for key, model in models.items()}
    assert names['nominal'] == set()
    assert names['textbook'] == {'rotor_inertia', 'coulomb_friction', 'viscous_friction',
                                 'torque_offset'}
    assert names['textbook'] < names['ours']
    np.testing.assert_array_equal(models['nominal'].mean, four_axes().nominal_links)


def test_run_case_of_an_arm_that_hardly_moves_is_incomplete(monkeypatch):
    monkeypatch.setattr(cases, 'DURATION', 0.5)
    robot = four_axes()
    model = exact_model('four')
    case = cases.Case(seeds.DEVELOPMENT_PLANTS[92], 1, LoadParameters(), 20.0, 0.3)
    found = run_case(robot, case, {'ours': model, 'textbook': model, 'nominal': model}, None,
                     ('lstm', 'bayes'))
    assert not complete([found])
