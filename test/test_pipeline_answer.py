"""The whole estimator without ROS: statuses, how soon the load is found, built from files."""

from dataclasses import replace

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
from pipeline_helpers import MASS, within
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import cases
from hand_load_estimator.benchmark.contestants import our_contestants
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_pipeline, determined_std
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.load import LoadParameters, STATUSES
from hand_load_estimator.robot import load_robot
from hand_load_estimator.torque.model_file import write_model


@pytest.fixture(scope='module')
def model():
    return exact_model('four')


@pytest.fixture(scope='module')
def stream(model):
    return messages(model, block(MASS), 5.0)


@pytest.fixture(scope='module')
def clean(model, stream):
    """Return the estimates of the undisturbed stream."""
    return feed(warm(pipeline_of(model)), stream)


def test_before_data_the_prior_and_no_data(model):
    estimate = pipeline_of(model).estimate(5.0)
    assert estimate.status == 'NO_DATA' and not estimate.determined.any()
    assert np.isfinite(estimate.mean).all() and np.isfinite(estimate.covariance).all()
    rated = model.robot.rated_load.mass
    assert 0.2 * rated < estimate.std[0] < rated


def test_statuses_follow_the_motion(clean):
    statuses = [e.status for e in clean]
    assert statuses[0] == 'WAITING_FOR_MOTION' and statuses[-1] == 'DETERMINED'
    order = [s for k, s in enumerate(statuses) if k == 0 or s != statuses[k - 1]]
    assert order == ['WAITING_FOR_MOTION', 'ESTIMATING', 'DETERMINED']
    moving = next(e.stamp for e in clean if e.status != 'WAITING_FOR_MOTION')
    assert 100.6 < moving < 101.0
    assert {e.status for e in clean} <= set(STATUSES)
    assert all(e.reason for e in clean)


def test_the_load_is_found(clean):
    assert within(clean[-1], block(MASS)) and clean[-1].std[0] < 0.05
    assert clean[-1].determined[:4].all()


def test_at_rest_nothing_is_claimed(model):
    pipeline = warm(pipeline_of(model))
    still = feed(pipeline, messages(model, block(MASS), 3.0, rest=9.0))
    assert {e.status for e in still} == {'WAITING_FOR_MOTION'}
    assert not any(e.determined[:4].all() for e in still)
    assert abs(still[-1].mean[0] - MASS) < 3.0 * still[-1].std[0]


def test_determined_is_std_below_the_stated_thresholds(model, clean):
    mass, place, inertia = determined_std(model.robot)
    limits = np.repeat([mass, place, inertia], [1, 3, 6])
    for estimate in clean[::20]:
        np.testing.assert_array_equal(estimate.determined, estimate.std < limits)
    assert mass == 0.01 * model.robot.rated_load.mass


def test_silence_is_stale_and_data_end_it(model, stream):
    pipeline = warm(pipeline_of(model))
    feed(pipeline, stream[:300])
    now = stream[299].stamp
    fresh = pipeline.estimate(now + 0.3)
    stale = pipeline.estimate(now + 0.7)
    assert fresh.status != 'STALE_INPUT' and stale.status == 'STALE_INPUT'
    np.testing.assert_array_equal(stale.mean, fresh.mean)
    assert '0.70 s' in stale.reason
    feed(pipeline, stream[300:320])
    assert pipeline.estimate(stream[319].stamp).status == fresh.status


def test_a_residual_nothing_explains_is_a_model_mismatch(model, stream):
    """A joint pulled by something outside for a second is told, and forgotten afterwards."""
    pull = np.array([0.0, 0.0, 0.0, 4.0])
    pulled = [replace(m, effort=m.effort + pull * np.sin(60.0 * m.stamp))
              if 103.0 < m.stamp < 104.0 else m for m in stream]
    estimates = feed(warm(pipeline_of(model)), pulled)
    mismatch = [e.stamp for e in estimates if e.status == 'MODEL_MISMATCH']
    assert mismatch and 103.0 < mismatch[0] < 103.7
    assert 'j3' in next(e.reason for e in estimates if e.status == 'MODEL_MISMATCH')


@pytest.mark.parametrize('seed', range(6))
def test_e1_7_the_mass_is_there_a_fifth_of_a_second_after_the_motion_starts(seed):
    """Issue 4 asks for 5 % of the rated load; at the start nothing was known but a wide prior."""
    model = exact_model('ur10e')
    mass, rated = 1.0 + 1.5 * seed, model.robot.rated_load.mass
    estimates = feed(warm(pipeline_of(model)), messages(model, block(mass), 2.5, seed=seed))
    start = next(e.stamp for e in estimates if e.status != 'WAITING_FOR_MOTION')
    early = next(e for e in estimates if e.stamp >= start + 0.2)
    assert estimates[0].std[0] > 0.2 * rated
    assert abs(early.mean[0] - mass) < min(0.05 * rated, 3.5 * early.std[0])


def test_e1_7_the_shipped_network_is_as_quick_on_an_arm_it_never_saw(monkeypatch):
    """A development plant with friction, drives and sensors of its own, not the torque model."""
    monkeypatch.setattr(cases, 'DURATION', 6.0)
    robot, plant = load_robot(find_shared('ur10e', 'robots')), seeds.DEVELOPMENT_PLANTS[94]
    recorded = cases.Recorded((('excite', 20.0, 20.0), ('pick_place', 30.0, 20.0)))
    identified = identify(robot, cases.identification_evidence(robot, plant, recorded=recorded))
    rated = robot.rated_load.mass
    for seed in seeds.DEVELOPMENT_CASES[890:894]:
        case = cases.draw_case(robot, plant, seed)
        run = cases.case_run(robot, case)
        (contestant,) = our_contestants(identified, ('lstm',), None).values()
        assert contestant.method.name == 'lstm'
        beliefs = [contestant.update(s) for s in run.samples if s.stamp < run.start + 0.22]
        first, early = (np.sqrt(belief.covariance[0, 0]) for belief in (beliefs[0], beliefs[-1]))
        assert first > 0.1 * rated
        assert abs(beliefs[-1].mean[0] - case.load.mass) < min(0.05 * rated, 3.5 * early)


def test_reset_forgets_the_load(model, stream, clean):
    pipeline = warm(pipeline_of(model))
    feed(pipeline, stream[:400])
    pipeline.reset()
    forgotten = pipeline.estimate(stream[399].stamp)
    prior = pipeline_of(model).estimate(0.0)
    np.testing.assert_allclose(forgotten.mean, prior.mean)
    np.testing.assert_allclose(forgotten.covariance, prior.covariance)
    estimates = feed(pipeline, [replace(m, stamp=m.stamp + 4.5) for m in messages(
        model, block(1.0), 5.0, seed=2)])
    assert within(estimates[-1], block(1.0)) and pipeline.load_id == 0


def test_the_residual_is_the_difference_to_the_model(model, stream):
    pipeline = warm(pipeline_of(model))
    assert np.isnan(pipeline.residual).all()
    feed(pipeline, stream)
    empty = warm(pipeline_of(model))
    feed(empty, messages(model, LoadParameters(), 5.0))
    noise = model.residuals.rmse
    assert (np.abs(empty.residual) < 6.0 * noise).all()
    assert (np.abs(pipeline.residual) > 6.0 * noise).any()


def test_a_pipeline_from_files(model, tmp_path, stream, clean):
    write_model(tmp_path / 'm.yaml', model)
    pipeline = warm(build_pipeline(tmp_path / 'm.yaml', 'bayes'))
    assert pipeline.method.name == 'bayes'
    last = feed(pipeline, stream)[-1]
    np.testing.assert_allclose(last.mean, clean[-1].mean, atol=1e-4)


def test_lstm_without_an_artefact_is_bayes_and_says_so(model, tmp_path):
    write_model(tmp_path / 'm.yaml', model)
    assert build_pipeline(tmp_path / 'm.yaml', 'lstm').method.name == 'bayes'


def test_a_wrong_method_or_robot_is_refused(model, tmp_path):
    path = tmp_path / 'm.yaml'
    write_model(path, model)
    with pytest.raises(ConfigurationError, match='method.*magic.*lstm'):
        build_pipeline(path, 'magic')
    with pytest.raises(ConfigurationError, match='learned'):
        build_pipeline(path, 'bayes', learned=str(tmp_path))
    with pytest.raises(ConfigurationError, match='another robot'):
        build_pipeline(path, 'bayes', robot_path='ur10e')
    with pytest.raises(ConfigurationError, match='nowhere'):
        build_pipeline('nowhere', 'bayes')
