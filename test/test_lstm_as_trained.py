"""The LSTM method: numpy runs what torch trained, on the features it was trained on."""

from core_helpers import block, exact_model, feed, four_axes, messages, warm
from lstm_helpers import loud_network, pipeline_with
import numpy as np
import pytest
import torch

from hand_load_estimator.estimators import lstm as lstm_module, regression
from hand_load_estimator.estimators.lstm_cell import LstmCell
from hand_load_estimator.estimators.model_trust import ModelTrust
from hand_load_estimator.estimators.weighting import joined_columns
from hand_load_estimator.learning.features import feature_count, features, REFRESH
from hand_load_estimator.learning.objective import answers, last_moving
from hand_load_estimator.learning.shards import (bayes_pass, moves, prior_tensors,
                                                  slow_residuals)


@pytest.fixture(scope='module')
def robot():
    return four_axes()


@pytest.fixture(scope='module')
def loud(tmp_path_factory, robot):
    """Return (network, artefact) of a network that speaks on all outputs."""
    return loud_network(tmp_path_factory.mktemp('loud'), robot)


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
                'moving': moves(stack(samples, 'v')),
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


def test_what_was_said_is_held_while_the_arm_stands():
    said = torch.arange(1.0, 7.0)[None, :, None] * torch.ones(10)
    moving = torch.tensor([[False, True, True, False, False, True]])
    held = last_moving(said, moving)
    assert held[0, :, 3].tolist() == [0.0, 2.0, 3.0, 3.0, 3.0, 6.0]
    assert not last_moving(said, torch.zeros_like(moving)).any()
    velocity = torch.tensor([[[0.01, -0.019], [0.0, -0.021]]])
    assert moves(velocity).tolist() == [[False, True]]


def test_extreme_inputs_stay_finite(robot, loud):
    cell = LstmCell(loud[1].weights, robot.n)
    with np.errstate(over='ignore'):
        for size in (1e3, -1e3, 1e6):
            said = cell.step(np.full((robot.n, feature_count(robot.n)), size))
            assert np.isfinite(np.concatenate(said)).all()
