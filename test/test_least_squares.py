"""Method `least_squares`: row E7.2, selectable, with a covariance that holds."""

from copy import deepcopy
from dataclasses import replace
import json

from core_helpers import block, exact_model, feed, four_axes, messages, recording_of, warm
import numpy as np
from pipeline_helpers import within
import pytest

from hand_load_estimator.benchmark.rivals import LeastSquares as Rival
from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_method, build_pipeline, determined_std
from hand_load_estimator.estimators.contact_gate import ContactGate
from hand_load_estimator.estimators.least_squares import LeastSquares
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.estimators.pipeline import Pipeline
from hand_load_estimator.estimators.weighting import joined_columns
from hand_load_estimator.load import message_from_shape, products_from_message
from hand_load_estimator.recording import RecordingWriter
from hand_load_estimator.torque.model_file import write_model
from hand_load_estimator.torque.model_follower import ModelFollower
from hand_load_estimator.torque.presliding import STUCK_TIME

LOAD = block(2.0)


@pytest.fixture(scope='module')
def model():
    return exact_model('four')


def pipeline_of(model):
    """Return a fresh Pipeline of the method, by its name."""
    follower = ModelFollower(model)
    method = build_method(model, follower.uncertainties, 'least_squares')
    return warm(Pipeline(model, follower, method, determined_std(model.robot)))


def spied(pipeline):
    """Return the list that (sample, Prediction) of every update go to."""
    seen, update = [], pipeline.method.update

    def noting(sample, prediction):
        seen.append((sample, prediction))
        return update(sample, prediction)

    pipeline.method.update = noting
    return seen


def test_e7_2_the_answer_is_the_batch_solution_over_the_joints_that_move(model):
    pipeline = pipeline_of(model)
    seen = spied(pipeline)
    last = feed(pipeline, messages(model, LOAD, 5.0))[-1]
    assert within(last, LOAD) and last.status == 'DETERMINED' and pipeline.load_id == 0
    rows = [(p.load_columns[j], p.difference[j], model.residuals.rmse[j])
            for s, p in seen for j in range(4) if abs(s.v[j]) >= 0.02]
    assert 0.5 < len(rows) / (4 * len(seen)) < 0.95
    columns, difference, rmse = map(np.array, zip(*rows))
    mean, covariance = load_prior(model.robot).products
    known = np.linalg.inv(np.linalg.cholesky(covariance))
    batch = np.linalg.lstsq(np.vstack([columns / rmse[:, None], known]),
                            np.concatenate([difference / rmse, known @ mean]), rcond=None)[0]
    np.testing.assert_allclose(pipeline.method._products, batch, atol=1e-8)


def test_it_is_the_line_of_the_benchmark_on_our_model(model):
    """Whoever selects it gets what the tables show: the same mean, a covariance of its own."""
    pipeline, rival = pipeline_of(model), Rival(model, skip_standing=True)
    seen = spied(pipeline)
    for estimate in feed(pipeline, messages(model, LOAD, 2.0)):
        theirs = rival.update(*seen.pop(0))
        assert np.abs(estimate.mean - theirs.mean)[:4].max() < 1e-6
    assert estimate.std[0] > 1.5 * np.sqrt(theirs.covariance[0, 0])


@pytest.mark.parametrize('doubt', [0.0, 0.2])
def test_the_covariance_is_how_far_off_it_is(doubt):
    """Of arms that are off as the model says; P alone would be less than half as wide."""
    model, away = exact_model('four', doubt=doubt), []
    std = np.sqrt(np.diag(model.covariance))
    for seed in range(8):
        true = replace(model, mean=model.mean + std * np.random.default_rng([seed, 9]).normal(
            size=len(std)))
        pipeline = pipeline_of(model)
        last = feed(pipeline, messages(true, LOAD, 4.0, seed=seed))[-1]
        away.append((last.mean - LOAD.to_message()) / last.std)
    assert 0.5 < np.sqrt(np.mean(np.square(away))) < 1.3
    assert np.abs(away).max() < 4.0


def test_doubt_about_the_model_does_not_average_out():
    stds = {}
    for doubt in (0.0, 0.2):
        model = exact_model('four', doubt=doubt)
        found = feed(pipeline_of(model), messages(model, LOAD, 8.0))
        stds[doubt] = [next(e for e in found if e.stamp > 100.0 + t).std[0] for t in (3.0, 7.9)]
    # Noise alone is a sixth of it by then.
    assert stds[0.2][1] > 3.0 * stds[0.0][1]


def test_doubt_about_torque_constants_is_in_it():
    """As much as the mass moves where one joint after the other reads the load 5 % too high."""
    currents = {'kind': 'motor_current', 'includes_configured_load': False,
                'torque_constants': [1.0] * 4}

    def last(doubt, joint=None):
        robot = four_axes(effort={**currents, 'torque_constants_std': doubt})
        model = replace(exact_model('four'), robot=robot)
        stream = messages(model, LOAD, 4.0)
        if joint is not None:
            own = 0.05 * (np.arange(4) == joint)
            stream = [replace(m, effort=m.effort + own * (m.effort - free.effort))
                      for m, free in zip(stream, messages(model, block(0.0), 4.0))]
        return feed(pipeline_of(model), stream)[-1]

    sure = last(0.0)
    moved = [last(0.0, joint).mean[0] - sure.mean[0] for joint in range(4)]
    told = np.sqrt(last(0.05).std[0] ** 2 - sure.std[0] ** 2)
    assert told == pytest.approx(np.linalg.norm(moved), rel=0.1)


def test_what_torques_do_not_tell_is_as_before(model):
    prior, pipeline = load_prior(model.robot), pipeline_of(model)
    before = pipeline.method.belief()
    np.testing.assert_allclose(before.mean, message_from_shape(prior.mean), atol=1e-12)
    np.testing.assert_allclose(np.sqrt(np.diag(before.covariance))[:4], prior.std[:4], rtol=1e-6)
    assert np.linalg.eigvalsh(before.covariance).min() > 0.0
    still = feed(pipeline, messages(model, LOAD, 2.0, rest=9.0))
    np.testing.assert_allclose(still[-1].mean, before.mean, atol=1e-12)
    np.testing.assert_allclose(still[-1].std, np.sqrt(np.diag(before.covariance)))
    # Only the last joint swings: of ten products the torque of one joint tells but some.
    pose = messages(model, LOAD, 4.0, rest=9.0)[0].position
    one = [replace(m, position=np.where(np.arange(4) < 3, pose, m.position),
                   velocity=m.velocity * (np.arange(4) == 3))
           for m in messages(model, LOAD, 4.0)]
    last = feed(pipeline_of(model), one)[-1]
    assert np.isfinite(last.covariance).all() and last.std[0] > 0.3 * prior.std[0]


def test_a_hand_without_a_load_has_a_place_within_reach_and_no_certainty_of_it(model):
    for seed in range(3):
        pipeline = pipeline_of(model)
        for estimate in feed(pipeline, messages(model, block(0.0), 4.0, seed=seed)):
            assert np.isfinite(estimate.covariance).all()
        belief = pipeline.method.belief()
        assert abs(belief.mean[0]) < 4.0 * np.sqrt(belief.covariance[0, 0]) < 0.2
        assert np.abs(belief.mean[1:4]).max() < 1.0
        assert not estimate.determined[1:4].any()


def test_reset_and_tare(model):
    pipeline, stream = pipeline_of(model), messages(model, LOAD, 4.0)
    fresh = pipeline.method.belief()
    feed(pipeline, stream)
    pipeline.reset()
    np.testing.assert_array_equal(pipeline.method.belief().mean, fresh.mean)
    np.testing.assert_array_equal(pipeline.method.belief().covariance, fresh.covariance)
    later = [replace(m, stamp=m.stamp + 5.0) for m in stream]
    feed(pipeline, later)
    held, untared = pipeline.method.belief(), deepcopy(pipeline)
    untared.reset()
    pipeline.tare(pipeline.last_stamp)
    np.testing.assert_allclose(pipeline.method.tared, products_from_message(held.mean), rtol=1e-6)
    last = feed(pipeline, [replace(m, stamp=m.stamp + 10.0) for m in stream])[-1]
    assert abs(last.mean[0]) < 3.5 * last.std[0]
    # The doubt about what was tared stays, beside that of what is held now.
    again = feed(untared, [replace(m, stamp=m.stamp + 10.0) for m in stream])[-1]
    assert last.std[0] ** 2 == pytest.approx(held.covariance[0, 0] + again.std[0] ** 2, rel=0.12)
    pipeline.reset()
    np.testing.assert_allclose(pipeline.method.tared, products_from_message(held.mean), rtol=1e-6)


def test_the_covariance_is_the_sum_over_samples_of_what_is_stated(monkeypatch):
    """Written out: noise, friction that lasts, and directions, of every pair of samples."""
    monkeypatch.setattr(LeastSquares, 'factor', 2.5)
    model = exact_model('four', doubt=0.05)
    pipeline = pipeline_of(model)
    seen, method = spied(pipeline), pipeline.method
    update, noisier = method.update, 3.0 * model.residuals.rmse ** 2
    method.update = lambda sample, prediction: update(sample, replace(prediction, noise=noisier))
    feed(pipeline, messages(model, LOAD, 1.4))
    dt = np.array([s.dt for s, _ in seen])
    weighted = np.array([(p.load_columns / model.residuals.rmse[:, None] ** 2)
                         * (np.abs(s.v) >= 0.02)[:, None] for s, p in seen])
    noise = np.array([model.residuals.load_intensity / s.dt + p.noise for s, p in seen])
    friction = np.array([np.sqrt(model.residuals.load_share * p.stuck) for _, p in seen])
    age = np.abs(np.cumsum(dt)[:, None] - np.cumsum(dt))
    lasts = np.einsum('tj,sj,ts->tsj', friction, friction, np.exp(-age / STUCK_TIME))
    lasting = np.einsum('tji,tsj,sjk->ik', weighted, lasts, weighted)
    errors = np.einsum('tji,tj,tjk->ik', weighted, noise, weighted) + lasting
    through = sum(w.T @ joined_columns(p)[:, 10:] for w, (_, p) in zip(weighted, seen))
    before = np.linalg.inv(load_prior(model.robot).products[1])
    told = sum(w.T @ p.load_columns for w, (_, p) in zip(weighted, seen))
    spread = np.linalg.inv(told + before)
    wanted = spread @ (before + 2.5 * (errors + through @ through.T)) @ spread
    scale = np.sqrt(np.diag(wanted))
    np.testing.assert_allclose(method._covariance / np.outer(scale, scale),
                               wanted / np.outer(scale, scale), atol=1e-6)
    # Each is a thousand times what is let pass above.
    for part in (errors - lasting, lasting, through @ through.T):
        assert (spread @ part @ spread)[0, 0] > 1e-3 * wanted[0, 0]


@pytest.mark.parametrize('settle', [False, True])
def test_a_changed_load_is_found_anew(model, settle):
    """Also where it is seen between samples, as a node looks for it."""
    pipeline, found = pipeline_of(model), []
    for message in messages(model, block(0.5), 6.0, seed=3, change=(3.0, block(3.0))):
        found += feed(pipeline, [message])
        if settle:
            pipeline.settle()
    assert pipeline.load_id == 1 and within(found[-1], block(3.0))


def test_samples_of_a_contact_do_not_count(model, monkeypatch):
    stream, pipeline = messages(model, LOAD, 2.4), pipeline_of(model)
    before = feed(pipeline, stream[:160])[-1]
    for name in ('update', 'refuses'):
        monkeypatch.setattr(ContactGate, name, lambda *_: True)
    after = feed(pipeline, stream[160:])[-1]
    np.testing.assert_array_equal(after.mean, before.mean)
    monkeypatch.undo()
    free = feed(pipeline_of(model), stream)[-1]
    assert np.abs(free.mean - before.mean).max() > 1e-4


def test_it_is_selected_by_name_and_learns_nothing(model, tmp_path):
    write_model(tmp_path / 'model.yaml', model)
    assert build_pipeline(tmp_path / 'model.yaml', 'least_squares').method.name == 'least_squares'
    with pytest.raises(ConfigurationError, match='learned.*not with least_squares'):
        build_pipeline(tmp_path / 'model.yaml', 'least_squares', str(tmp_path))
    with RecordingWriter(tmp_path / 'run') as writer:
        for sample in recording_of(messages(model, LOAD, 4.0), model.robot.joints).samples:
            writer.write(sample)
    out = tmp_path / 'e.json'
    assert main(['estimate', str(tmp_path / 'run'), '--model', str(tmp_path / 'model.yaml'),
                 '--method', 'least_squares', '--out', str(out)]) == 0
    told = json.loads(out.read_text('utf-8'))
    assert told['method'] == 'least_squares' and told['status'] == 'DETERMINED'
    assert abs(told['mass']['mean'] - LOAD.mass) < 3.5 * told['mass']['std'] < 0.2
