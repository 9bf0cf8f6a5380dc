"""The LSTM method: numpy runs what torch trained, on the features it was trained on."""

import json

from core_helpers import block, exact_model, feed, four_axes, messages, pipeline_of, warm
import numpy as np
import pytest
import torch

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators import lstm as lstm_module, regression
from hand_load_estimator.estimators.build import build_method, determined_std
from hand_load_estimator.estimators.checkpoint import (belongs_to, CheckpointError,
                                                       restore_checkpoint, write_checkpoint)
from hand_load_estimator.estimators.lstm import Lstm, LstmCell
from hand_load_estimator.estimators.model_trust import ModelTrust
from hand_load_estimator.estimators.pipeline import Pipeline
from hand_load_estimator.estimators.weighting import joined_columns
from hand_load_estimator.learning.artefact import arm_of, read_artefact, write_artefact
from hand_load_estimator.learning.features import feature_count, features, REFRESH
from hand_load_estimator.learning.interval_factors import factors_at, level_of, LEVELS
from hand_load_estimator.learning.network import LoadNetwork
from hand_load_estimator.learning.objective import answers
from hand_load_estimator.learning.shards import bayes_pass, prior_tensors, slow_residuals
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.model_follower import ModelFollower

HIDDEN = 12
NEUTRAL = np.ones((10, len(LEVELS)))


def network_of(robot, seed=1, size=0.3):
    """Return a double-precision network with heads that say something of that size."""
    torch.manual_seed(seed)
    network = LoadNetwork(feature_count(robot.n), robot.n, HIDDEN).double()
    with torch.no_grad():
        for head in (network.joint_head, network.load_head):
            for value in head.parameters():
                value.normal_(0.0, size)
    return network


def artefact_of(folder, robot, network, calibration=None, **card):
    """Write a network as an artefact and return it as it is read."""
    weights = {k: v.detach().float().numpy() for k, v in network.state_dict().items()}
    write_artefact(folder, weights, NEUTRAL if calibration is None else calibration,
                   {**arm_of(robot), **card})
    return read_artefact(folder, robot)


def rounded(network):
    """Return the network with its weights as the artefact's single precision keeps them."""
    return network.float().double()


def pipeline_with(model, artefact):
    follower = ModelFollower(model)
    return Pipeline(model, follower, Lstm(model, follower.uncertainties, artefact),
                    determined_std(model.robot))


@pytest.fixture(scope='module')
def robot():
    return four_axes()


@pytest.fixture(scope='module')
def silent(tmp_path_factory, robot):
    """Return the artefact of a network that has learnt nothing: all outputs zero."""
    network = network_of(robot, size=0.0)
    return artefact_of(tmp_path_factory.mktemp('silent'), robot, network)


@pytest.fixture(scope='module')
def loud(tmp_path_factory, robot):
    """Return (network, artefact) of a network that speaks on all outputs."""
    network = rounded(network_of(robot))
    return network, artefact_of(tmp_path_factory.mktemp('loud'), robot, network)


def test_the_numpy_cell_is_torchs_lstm(robot, loud):
    network, artefact = loud
    rng = np.random.default_rng(1)
    inputs = rng.normal(0.0, 1.5, (200, robot.n, feature_count(robot.n)))
    cell = LstmCell(artefact.weights, robot.n)
    ours = [np.concatenate(cell.step(row)) for row in inputs]
    with torch.no_grad():
        theirs = torch.cat(network(torch.tensor(inputs)[None]), dim=-1)[0].numpy()
    assert np.ptp(theirs, axis=0).min() > 0.05
    np.testing.assert_allclose(ours, theirs, atol=1e-5)
    cell.restart()
    np.testing.assert_allclose(np.concatenate(cell.step(inputs[0])), ours[0], atol=1e-12)


class Spy:
    """Notes what a Lstm sees and says while a stream runs through it."""

    def __init__(self, monkeypatch, model, artefact):
        self.inputs, self.samples, self.predictions, self.beliefs = [], [], [], []
        monkeypatch.setattr(lstm_module, 'features', self._features)
        self.pipeline = warm(pipeline_with(model, artefact))
        method = self.pipeline.method
        update = method.update

        def spied(sample, prediction):
            self.samples.append(sample)
            self.predictions.append(prediction)
            self.beliefs.append(update(sample, prediction))
            return self.beliefs[-1]

        method.update = spied

    def _features(self, *arguments):
        self.inputs.append(features(*arguments))
        return self.inputs[-1]

    def shard(self, model):
        """Return the batch that training would have made of the same samples."""
        count = len(self.samples) // REFRESH * REFRESH
        samples, predictions = self.samples[:count], self.predictions[:count]

        def stack(things, name):
            return torch.tensor(np.array([getattr(t, name) for t in things]))[None]

        difference, density = stack(predictions, 'difference'), stack(predictions, 'density')
        columns = torch.tensor(np.array([joined_columns(p) for p in predictions]))[None]
        dt = torch.tensor([s.dt for s in samples])
        weights = dt[None, :, None] / density
        *load, relative = bayes_pass(model.robot, columns, difference, weights)
        slow = slow_residuals(load[0].numpy(), load[1].numpy(), density.numpy())
        inputs = features(
            model.robot.limits, (model.residuals.rmse, model.residuals.intensity),
            tuple(np.array([getattr(s, name) for s in samples]) for name in 'qva'),
            np.array([s.temperature for s in samples]) - model.robot.reference_temperature,
            tuple(np.array([getattr(p, name) for p in predictions])
                  for name in ('z', 'doubt', 'density')),
            difference[0].numpy(), [x[0].numpy() for x in load], slow[:, 0], relative[0].numpy())
        return {'inputs': torch.tensor(inputs)[None], 'columns': columns,
                'difference': difference, 'weights': weights,
                'level': torch.tensor(model.friction_level())[None]}


@pytest.fixture
def spied(monkeypatch, loud):
    """
    Return (model, spy, network) after a stream.

    Nothing fades, and the model is trusted as it states, as in training.
    """
    monkeypatch.setattr(regression, 'MEMORY', 1e12)
    monkeypatch.setattr(ModelTrust, 'look', lambda *arguments: None)
    model, (network, artefact) = exact_model('four'), loud
    spy = Spy(monkeypatch, model, artefact)
    feed(spy.pipeline, messages(model, block(2.0), 4.0))
    assert len(spy.samples) > 150 and spy.pipeline.load_id == 0
    return model, spy, network


def test_features_are_the_same_in_training_and_running(spied):
    model, spy, _ = spied
    batch = spy.shard(model)['inputs'][0].numpy()
    running = np.array(spy.inputs[:len(batch)])
    assert running.shape[1:] == (model.robot.n, feature_count(model.robot.n))
    # The first solutions of a chunk are 3 Gauss-Newton steps here and 5 there.
    np.testing.assert_allclose(running, batch, atol=1e-3)
    # Joint numbers, the temperature and that it is known, and dt stand still; the rest moves.
    still = (np.ptp(batch, axis=0) < 1e-9).sum()
    assert still <= model.robot.n * (model.robot.n + 3)


def test_answers_are_the_same_in_training_and_running(spied):
    """Mean and variance after every fifth sample: layer, network and estimator agree."""
    model, spy, network = spied
    shard = spy.shard(model)
    judged = range(4, len(spy.beliefs) // REFRESH, 5)
    with torch.no_grad():
        mean, variance, _ = answers(network, shard, *prior_tensors(model.robot), judged=judged)
    for place, k in enumerate(judged):
        belief = spy.beliefs[(k + 1) * REFRESH - 1]
        std = np.sqrt(np.diag(belief.covariance))
        np.testing.assert_allclose((belief.mean - mean[0, place].numpy()) / std, 0.0, atol=0.01)
        np.testing.assert_allclose(std, np.sqrt(variance[0, place].numpy()), rtol=0.01)


def test_a_network_that_says_nothing_is_bayes(silent):
    model = exact_model('four')
    stream = messages(model, block(2.0), 4.0)
    plain = feed(warm(pipeline_of(model)), stream)
    ours = feed(warm(pipeline_with(model, silent)), stream)
    for one, other in zip(plain[::10], ours[::10]):
        np.testing.assert_allclose(one.mean, other.mean, atol=1e-6)
        np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-4, atol=1e-12)


def test_the_network_changes_the_answer(silent, loud):
    model = exact_model('four')
    stream = messages(model, block(2.0), 2.5)
    quiet = feed(warm(pipeline_with(model, silent)), stream)[-1]
    spoken = feed(warm(pipeline_with(model, loud[1])), stream)[-1]
    moved = np.abs(spoken.mean - quiet.mean) / quiet.std
    widened = np.abs(np.log(spoken.std / quiet.std))
    assert moved.max() > 0.1 and widened.max() > 0.1, (moved, widened)
    assert np.abs(np.log(spoken.std / quiet.std)).max() > 0.1


def test_calibration_scales_standard_deviations(tmp_path, robot, silent):
    factors = np.linspace(0.8, 2.0, 10)[:, None] * np.ones(len(LEVELS))
    wide = artefact_of(tmp_path, robot, network_of(robot, size=0.0), factors)
    model = exact_model('four')
    stream = messages(model, block(2.0), 2.0)
    one, other = (feed(warm(pipeline_with(model, a)), stream)[-1] for a in (silent, wide))
    np.testing.assert_allclose(other.std / one.std, factors[:, 0], rtol=1e-5)
    np.testing.assert_array_equal(other.mean, one.mean)


def test_factors_follow_how_well_a_parameter_is_determined():
    factors = np.tile(np.arange(1.0, 7.0), (10, 1))
    level = level_of(np.full(10, 10.0 ** -1.25), np.ones(10))
    np.testing.assert_allclose(factors_at(factors, level), 3.5)
    # Beyond the levels the outermost factors hold.
    np.testing.assert_allclose(factors_at(factors, np.full(10, -4.0)), 1.0)
    np.testing.assert_allclose(factors_at(factors, level_of(np.full(10, 3.0), np.ones(10))), 6.0)


def test_factors_are_interpolated_linearly_one_row_each():
    rng = np.random.default_rng(1)
    factors, level = rng.uniform(0.5, 3.0, (10, len(LEVELS))), rng.uniform(-3.0, 0.5, 10)
    # Shares by distance are an interpolation at even spacing only.
    assert np.ptp(np.diff(LEVELS)) == 0.0
    np.testing.assert_allclose(
        factors_at(factors, level),
        [np.interp(x, LEVELS, row) for x, row in zip(level, factors)], rtol=1e-13)


def test_a_changed_load_is_noticed_in_step_with_bayes(silent):
    model = exact_model('four')
    stream = messages(model, LoadParameters(), 5.0, change=(2.5, block(2.0)))
    bayes, pipeline = warm(pipeline_of(model)), warm(pipeline_with(model, silent))
    plain, ours = feed(bayes, stream), feed(pipeline, stream)
    assert [e.load_id for e in ours] == [e.load_id for e in plain]
    assert pipeline.load_id > 0
    # Both regressions must have dropped the same data.
    np.testing.assert_allclose(ours[-1].mean, plain[-1].mean, atol=1e-5)
    np.testing.assert_allclose(ours[-1].std, plain[-1].std, rtol=1e-3)


def test_reset_and_tare_reach_the_network(silent, loud):
    model = exact_model('four')
    stream = messages(model, block(2.0), 2.5)
    for artefact in (silent, loud[1]):
        pipeline = warm(pipeline_with(model, artefact))
        fresh = pipeline.estimate(0.0)
        feed(pipeline, stream)
        pipeline.reset()
        np.testing.assert_allclose(pipeline.estimate(0.0).mean, fresh.mean)
        np.testing.assert_allclose(pipeline.estimate(0.0).covariance, fresh.covariance)
    pipeline, plain = warm(pipeline_with(model, silent)), warm(pipeline_of(model))
    for p in (pipeline, plain):
        feed(p, stream)
        p.tare(p.last_stamp)
        feed(p, [type(m)(m.stamp + 3.0, *list(vars(m).values())[1:]) for m in stream])
    np.testing.assert_allclose(pipeline.estimate(0.0).mean, plain.estimate(0.0).mean, atol=1e-5)


def test_extreme_inputs_stay_finite(robot, loud):
    cell = LstmCell(loud[1].weights, robot.n)
    with np.errstate(over='ignore'):
        for size in (1e3, -1e3, 1e6):
            said = cell.step(np.full((robot.n, feature_count(robot.n)), size))
            assert np.isfinite(np.concatenate(said)).all()


# The artefact as files.

def test_the_artefact_is_two_small_files_without_pickle(tmp_path, robot):
    artefact_of(tmp_path, robot, network_of(robot))
    assert sorted(p.name for p in tmp_path.iterdir()) == ['card.json', 'lstm.safetensors']
    assert json.loads((tmp_path / 'card.json').read_text())['schema'] == 'hand_load/learned/1'


def test_the_artefact_runs_with_any_model_of_the_arm(robot, loud):
    """Another model of the same joints: other effects, other numbers of nuisances."""
    for model in (exact_model('four'), exact_model('four', ('coulomb_friction',)),
                  exact_model('four', doubt=0.05)):
        last = feed(warm(pipeline_with(model, loud[1])), messages(model, block(2.0), 1.5))[-1]
        assert np.isfinite(last.mean).all() and (last.std > 0.0).all()


def wreck(folder, how):
    """Damage an artefact in a named way."""
    weights, card = folder / 'lstm.safetensors', folder / 'card.json'
    content = json.loads(card.read_text())
    changes = {'joints': ['a', 'b', 'c', 'd'], 'effort_kind': 'motor_current',
               'schema': 'hand_load/learned/9', 'places': None}
    if how in changes:
        card.write_text(json.dumps({**content, how: changes[how]}))
    elif how == 'card is a list':
        card.write_text('[]')
    elif how == 'joints are a number':
        card.write_text(json.dumps({**content, 'joints': 4}))
    elif how == 'card is no JSON':
        card.write_text('{')
    elif how == 'no card':
        card.unlink()
    elif how == 'no weights':
        weights.unlink()
    elif how == 'weights cut':
        weights.write_bytes(weights.read_bytes()[:-50])
    elif how == 'weights are noise':
        weights.write_bytes(b'\xff' * 500)
    else:
        tensors = _read(weights)
        if how == 'a tensor missing':
            del tensors['load_head.bias']
        elif how == 'a tensor of another shape':
            tensors['load_head.bias'] = tensors['load_head.bias'][:-1]
        elif how == 'a tensor of another rank':
            tensors['lstm.weight_hh_l0'] = tensors['lstm.weight_hh_l0'].ravel()
        elif how == 'a NaN':
            tensors['load_head.bias'][0] = np.nan
        elif how == 'a calibration of nothing':
            tensors['calibration'][0] = 0.0
        _write(weights, tensors)


def _read(path):
    from safetensors.numpy import load_file
    return {k: v.copy() for k, v in load_file(path).items()}


def _write(path, tensors):
    from safetensors.numpy import save_file
    save_file(tensors, path)


@pytest.mark.parametrize('how', [
    'joints', 'effort_kind', 'schema', 'places', 'card is a list', 'joints are a number',
    'card is no JSON', 'no card', 'no weights', 'weights cut', 'weights are noise',
    'a tensor missing', 'a tensor of another shape', 'a tensor of another rank', 'a NaN',
    'a calibration of nothing'])
def test_what_does_not_belong_or_is_damaged_is_refused(tmp_path, robot, how):
    artefact_of(tmp_path, robot, network_of(robot))
    wreck(tmp_path, how)
    with pytest.raises(ConfigurationError) as caught:
        read_artefact(tmp_path, robot)
    assert str(tmp_path) in str(caught.value)


def test_build_takes_the_named_artefact(tmp_path, robot):
    artefact_of(tmp_path, robot, network_of(robot))
    model = exact_model('four')
    method = build_method(model, ModelFollower(model).uncertainties, 'lstm', str(tmp_path))
    assert method.name == 'lstm'


def test_the_network_goes_on_from_a_checkpoint(robot, loud, tmp_path):
    model = exact_model('four')
    old, new = (warm(pipeline_with(model, loud[1])) for _ in range(2))
    feed(old, messages(model, block(3.0), 3.0))
    write_checkpoint(tmp_path / 'c', old.state(), belongs_to(old))
    restore_checkpoint(tmp_path / 'c', new, 60.0)
    # How far the model is trusted since it settled counts from the next sample on.
    old.method._learned.update_posterior()
    before, after = old.method.belief(), new.method.belief()
    std = np.sqrt(np.diag(before.covariance))
    np.testing.assert_allclose(after.mean / std, before.mean / std, atol=1e-3)
    np.testing.assert_allclose(after.covariance / np.outer(std, std),
                               before.covariance / np.outer(std, std), atol=1e-3)
    assert new.method.state()['memory'].any()
    other = artefact_of(tmp_path / 'b', robot, network_of(robot, seed=2))
    with pytest.raises(CheckpointError, match='another learned artefact'):
        restore_checkpoint(tmp_path / 'c', pipeline_with(model, other), 60.0)
