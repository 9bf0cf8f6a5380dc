"""Stated variances are counted by their load_share in estimates, and in full by who watches."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import block, exact_model, messages
import numpy as np
import pytest

from hand_load_estimator.estimators import change_windows
from hand_load_estimator.estimators.bayes import Bayes
from hand_load_estimator.estimators.change import EVIDENCE
from hand_load_estimator.estimators.contact_gate import ContactGate
from hand_load_estimator.estimators.information import Information
from hand_load_estimator.estimators.residual_watch import ResidualWatch
from hand_load_estimator.estimators.tool import read_tool, ToolFollower
from hand_load_estimator.estimators.weighting import joined_columns
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.stream.joint_stream import JointStream
from hand_load_estimator.torque.misread_weight import misread_directions
from hand_load_estimator.torque.model_follower import ModelFollower

LOAD = block(2.0)
SHARES = 1.0, 0.25
# What misreads weights is none of what the model states, and is counted in full.
AHEAD = misread_directions(4)


def model_of(share):
    """Return a model in doubt about friction that states a load_share."""
    model = exact_model('four', doubt=0.1)
    return replace(model, residuals=replace(model.residuals, load_share=share))


@pytest.fixture(scope='module')
def samples():
    """Return MotionSamples of 12 s with LOAD, a rest first."""
    model = model_of(1.0)
    stream = JointStream(model.robot)
    for joint in model.robot.joints:
        stream.temperature_reading(joint, 25.0)
    found = [stream.joint_state(m.stamp, m.names, m.position, m.velocity, m.effort)
             for m in messages(model, LOAD, 12.0)]
    return [sample for sample in found if sample is not None]


@pytest.fixture(scope='module')
def predicted(samples):
    """Return {share: Predictions}; noise is not measured, which would hide the share."""
    followers = {share: ModelFollower(model_of(share), measured=False) for share in SHARES}
    return {share: [f.update(s) for s in samples] for share, f in followers.items()}


def test_estimates_count_a_share_of_every_stated_variance(predicted):
    for full, shared in zip(*(predicted[share] for share in SHARES)):
        np.testing.assert_array_equal(shared.model_columns, full.model_columns)
        np.testing.assert_array_equal(shared.stuck, full.stuck)
        np.testing.assert_allclose(shared.density, 0.25 * full.density)
        counted = [joined_columns(p) for p in (full, shared)]
        told = 10 + AHEAD
        np.testing.assert_array_equal(*(columns[:, :told] for columns in counted))
        np.testing.assert_allclose(counted[1][:, told:], 0.5 * counted[0][:, told:])
    assert np.ptp(full.density) > 0.0 and full.model_columns[:, AHEAD:-12].any()


def test_a_load_is_known_as_much_better(samples, predicted):
    """A quarter of all a model states of variance: four times the information, the same load."""
    told = {}
    for share in SHARES:
        columns = [joined_columns(prediction) for prediction in predicted[share]]
        for row in columns:
            row[:, 10:10 + AHEAD] = 0.0
        information = Information(0, columns[0].shape[1] - 10)
        for sample, row, prediction in zip(samples, columns, predicted[share]):
            information.add_rows(row, prediction.difference, sample.dt / prediction.density)
        told[share] = information.load_share()
    for full, shared in zip(told[1.0], told[0.25]):
        np.testing.assert_allclose(shared, 4.0 * full, rtol=1e-6, atol=1e-9 * np.abs(full).max())


def test_what_a_tool_file_states_is_counted_in_full(samples, tmp_path):
    path = tmp_path / 'tool.yaml'
    write_load_file(path, block(0.5))
    path.write_text(path.read_text() + 'std: {mass: 0.1, com: [0.01, 0.01, 0.01]}\n')
    tool = read_tool(path)
    full, shared = (joined_columns(ToolFollower(ModelFollower(model_of(share)), tool)
                                   .update(samples[-1]))[:, 10:] for share in SHARES)
    own = tool.root.shape[1] + AHEAD
    assert own == 4 + AHEAD and full[:, :4].any()
    np.testing.assert_array_equal(shared[:, :own], full[:, :own])
    np.testing.assert_allclose(shared[:, own:], 0.5 * full[:, own:])


def test_the_watch_judges_by_what_is_stated(samples, predicted):
    """Friction of a joint grows: the ratio to the stated residual is that of any load_share."""
    ratios = []
    belief = SimpleNamespace(mean=LOAD.to_message(), covariance=np.zeros((10, 10)))
    method = SimpleNamespace(belief=lambda: belief, tared=np.zeros(10), changes=0, factor=1.0)
    for share in SHARES:
        model = model_of(share)
        watch = ResidualWatch(model.robot.joints, model.residuals.intensity)
        rubbed = model.residuals.rmse * [0.0, 2.0, 0.0, 0.0]
        for sample, prediction in zip(samples, predicted[share]):
            more = prediction.difference + rubbed * np.sign(sample.v)
            watch.update(sample, replace(prediction, difference=more), method)
        ratios.append(watch.ratio)
    np.testing.assert_array_equal(*ratios)
    assert ratios[0][1] > 0.5 and ratios[0].all()


def test_the_gate_judges_by_what_is_stated(samples, predicted):
    """Pushes that grow by and by: the same ones are contacts, moving and at rest."""
    decisions = []
    for share in SHARES:
        model = model_of(share)
        gate = ContactGate(model.robot.joints, model.residuals.rmse,
                           np.diag(np.full(10, 1e-2)))
        decisions.append([])
        for k, (sample, prediction) in enumerate(zip(samples, predicted[share])):
            held = prediction.load_columns @ LOAD.to_products()
            push = k / len(samples) * 40.0 * model.residuals.rmse * [1.0, -1.0, 1.0, -1.0]
            left = prediction.difference - held + push * (k % 20 < 5)
            decisions[-1] += [gate.update(prediction, left, held, sample.dt),
                              gate.refuses(prediction, left, held)]
    assert decisions[0] == decisions[1]
    assert 0.0 < np.mean(decisions[0]) < 1.0


@pytest.mark.parametrize('share, factor, changes', [
    (1.0, 2.0, True), (0.25, 2.0, False), (0.25, 5.0, True), (4.0, 0.5, False)])
def test_a_change_takes_evidence_beyond_what_the_share_makes_of_model_error(
        samples, predicted, monkeypatch, share, factor, changes):
    """Variances of a quarter make fourfold evidence of the same error; the limit never falls."""
    monkeypatch.setattr(change_windows, 'log_bayes_factor', lambda *_: factor * EVIDENCE)
    monkeypatch.setattr(Information, 'left_by', lambda *_: np.inf)
    method = Bayes(model_of(share), predicted[1.0][0].model_columns.shape[1])
    for sample, prediction in zip(samples[:100], predicted[1.0]):
        method.update(sample, prediction)
    assert (method.changes > 0) == changes
