"""What a torque model leaves without load, learned: Gaussian process and its alternatives."""

from dataclasses import dataclass, replace
import json

from core_helpers import EFFECTS, exact_model, messages, recording_of
from difference_helpers import data, evidence, lacking, model, NOTHING, speeds, stream
import numpy as np
import pytest

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.difference_function import DifferenceFunction
from hand_load_estimator.estimators.inducing_points import InducingPoints
from hand_load_estimator.estimators.network_draws import NetworkDraws
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.learning import (bayesian_network, distilled_network, neural_process,
                                          torque_gp)
from hand_load_estimator.learning.difference_artefact import CARD, read_difference, WEIGHTS
from hand_load_estimator.learning.difference_data import difference_data
from hand_load_estimator.learning.difference_inputs import (difference_inputs, input_width, INPUTS,
                                                            parse_inputs)
from hand_load_estimator.learning.learn_difference import learn_difference
from hand_load_estimator.stream.joint_stream import JointStream, motion_of
from hand_load_estimator.torque.model_file import model_digest, read_model, write_model
from hand_load_estimator.torque.model_follower import ModelFollower, Prediction


@pytest.fixture(scope='module')
def learned():
    """Return (tensors, LeftOut) of the Gaussian process of velocity."""
    return torque_gp.learn_gp(data(), 1)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return an artefact of velocity and temperature as the command makes it."""
    out = tmp_path_factory.mktemp('difference')
    learn_difference(out, model(), evidence())
    return out


def answers(predictor, v, names=('velocity',)):
    """Return mean [Nm] and std [Nm] (N, n) at velocities."""
    mean, variance = predictor.at(difference_inputs(names, 0 * v, v, 0 * v, 0 * v))
    scale = model().residuals.rmse
    return mean * scale, np.sqrt(variance) * scale


def relative_error(predictor, v):
    """Return the RMS error of a predictor over the RMS of what the model lacks."""
    mean, _ = answers(predictor, v)
    return np.sqrt(np.mean((mean - lacking(v)) ** 2) / np.mean(lacking(v) ** 2))


def test_e2_1_process_of_velocity_alone_finds_what_the_model_lacks(learned):
    process = InducingPoints(learned[0])
    assert relative_error(process, speeds(reach=0.4)) < 0.25
    assert (learned[1].share < 0.5).all()
    mean, std = answers(process, speeds(reach=0.4))
    inside = np.abs(mean - lacking(speeds(reach=0.4))) < 2.5 * std
    assert inside.mean() > 0.85


def test_e2_1_kernel_follows_the_data_by_likelihood(learned):
    """On pure noise the maximum of the likelihood is a process of nearly nothing."""
    noise = np.random.default_rng(1).normal(size=data().difference.shape)
    silent, left = torque_gp.learn_gp(replace(data(), difference=noise), 1)
    assert (silent['outputscale'] < 0.2 * learned[0]['outputscale']).all()
    assert (np.abs(left.share - 1.0) < 0.15).all()


def test_e2_1_learning_is_the_same_every_time(learned):
    again, _ = torque_gp.learn_gp(data(), 1)
    for name, tensor in learned[0].items():
        np.testing.assert_array_equal(again[name], tensor)


def test_e6_4_variance_grows_where_nothing_was_seen(learned):
    process = InducingPoints(learned[0])
    _, seen = answers(process, speeds(reach=0.4))
    _, far = answers(process, np.full((1, model().robot.n), 20.0))
    assert (far > 2.0 * np.median(seen, axis=0)).all()


def test_the_posterior_is_the_exact_regression_where_points_are_the_data(learned):
    """With an inducing point at every sample nothing is left out of the process."""
    few = replace(data(), **{name: getattr(data(), name)[::60] for name in (
        'inputs', 'difference', 'worth', 'owner', 'dt')})
    kernel = {**learned[0], 'noise': np.full(model().robot.n, 0.8),
              'points': few.inputs.swapaxes(0, 1).copy()}
    process = InducingPoints(torque_gp.process_posterior(few, kernel, np.ones(len(few.dt), bool)))
    x = speeds(5)
    mean, variance = process.at(difference_inputs(('velocity',), x, x, x, x))
    for j in range(model().robot.n):
        def k(a, b, j=j):
            r = np.sqrt(5.0) * np.abs(a[:, None] - b[None, :]) / learned[0]['lengthscale'][j]
            return learned[0]['outputscale'][j] * (1 + r + r * r / 3) * np.exp(-r)
        places, at = few.inputs[:, j, 0], np.arcsinh(x[:, j] / 0.05)
        full = k(places, places) + np.diag(0.8 / few.worth[:, j])
        np.testing.assert_allclose(mean[:, j], k(at, places) @ np.linalg.solve(
            full, few.difference[:, j]), rtol=1e-3, atol=1e-4)
        np.testing.assert_allclose(variance[:, j], np.diag(
            k(at, at) - k(at, places) @ np.linalg.solve(full, k(places, at))), rtol=2e-2,
            atol=1e-4)


def test_e2_5_a_known_load_teaches_the_same():
    told = data(mass=1.5)
    assert np.abs(told.difference - data().difference).max() < 0.5
    assert told.inputs.shape == data().inputs.shape


@pytest.mark.parametrize('left_out', [('coulomb_friction', 'viscous_friction',
                                       'presliding_hysteresis'),
                                      ('temperature_dependent_viscous_friction',)])
def test_e5_1_e5_2_what_is_identified_of_friction_is_not_left_to_learn(left_out):
    """Recordings at 45 degC, through a model with friction (and its temperature) and without."""
    whole = exact_model('four')
    poorer = exact_model('four', tuple(name for name in EFFECTS if name not in left_out))
    recording = recording_of(messages(whole, NOTHING, 8.0, temperature=45.0),
                             whole.robot.joints, 45.0)
    run = prepare(whole.robot, 'hot', motion_of(whole.robot, recording)[0], NOTHING)
    told, untold = (np.sqrt(np.mean(difference_data(m, [run], ('velocity',)).difference ** 2,
                                    axis=0)) for m in (whole, poorer))
    # In units of the noise: next to nothing but noise is left, or much more.
    assert (told < 1.5).all() and (untold > 1.5 * told).all(), (told, untold)


def test_e3_1_inputs_are_chosen_by_name():
    v = speeds(3)
    x = difference_inputs(('temperature', 'position'), v, 0 * v, 0 * v, 20.0 + 0 * v)
    np.testing.assert_allclose(x[..., 0], 2.0)
    np.testing.assert_allclose(x[..., 1], v)
    assert parse_inputs('velocity') == ('velocity',)
    for wrong in ('speed', 'velocity,velocity', ''):
        with pytest.raises(ConfigurationError, match='--inputs'):
            parse_inputs(wrong)
    assert set(INPUTS) == {'position', 'velocity', 'acceleration', 'temperature', 'pose'}


def test_e2_1_a_joint_may_see_the_pose_of_the_whole_arm():
    q = np.arange(8.0).reshape(2, 4)
    x = difference_inputs(('velocity', 'pose'), q, 0 * q, 0 * q, 0 * q)
    assert x.shape == (2, 4, 5) and input_width(('velocity', 'pose'), 4) == 5
    np.testing.assert_array_equal(x[..., 1:], np.broadcast_to(q[:, None], (2, 4, 4)))


def test_e2_1_what_a_wrong_link_leaves_is_learned_from_the_pose(tmp_path):
    """Torque of the first lifting joint by the angle of the second, not by its own."""
    runs = []
    for run in evidence():
        wrong = np.zeros_like(run.torque)
        wrong[:, 1] = 8.0 * np.sin(2.0 * run.motion.q[:, 2])
        runs.append(replace(run, torque=run.torque + wrong))
    own, pose = (learn_difference(tmp_path / name, model(), runs, 'gp', ('velocity', name),
                                  write=lambda text: None).share[1]
                 for name in ('position', 'pose'))
    assert pose < 0.6 * own, (pose, own)
    assert read_difference(tmp_path / 'pose', model()).inputs == ('velocity', 'pose')


def test_e2_6_a_network_distilled_from_the_process_answers_alike(learned, monkeypatch):
    monkeypatch.setattr(distilled_network, 'STEPS', 250)
    teacher = InducingPoints(learned[0])
    pupil = NetworkDraws(distilled_network.distil(data(), teacher, 1))
    compare(teacher, pupil)


def test_e2_6_a_bayesian_network_is_fitted_to_the_process(learned, monkeypatch):
    monkeypatch.setattr(bayesian_network, 'STEPS', 200)
    teacher = InducingPoints(learned[0])
    tensors = bayesian_network.learn_bayesian_network(data(), teacher, 1)
    draws = NetworkDraws(tensors)
    assert len(tensors['in_weight']) == bayesian_network.DRAWS
    assert np.ptp(tensors['out_bias'][..., 0], axis=0).min() > 0.0
    compare(teacher, draws)


@pytest.mark.parametrize('function, module', [('distilled', distilled_network),
                                              ('bayesian_network', bayesian_network)])
def test_e2_6_a_pupil_is_judged_by_its_own_answers(learned, tmp_path, monkeypatch, function,
                                                   module):
    """One that has hardly learned takes less off the residual than the process it follows."""
    monkeypatch.setattr(module, 'STEPS', 3)
    told = learn_difference(tmp_path, model(), evidence(), function, ('velocity',))
    assert (told.share > learned[1].share + 0.02).any()
    artefact = read_difference(tmp_path, model())
    np.testing.assert_allclose(artefact.share, told.share, rtol=1e-5)
    np.testing.assert_allclose(artefact.left_out_variance, told.variance, rtol=1e-5)


def test_e2_6_recordings_too_short_for_a_neural_process_are_refused():
    rows = slice(2 * neural_process.STRETCH - 1)
    few = replace(data(), **{name: getattr(data(), name)[rows] for name in (
        'inputs', 'difference', 'worth', 'owner', 'dt')})
    with pytest.raises(ConfigurationError, match='too short'):
        neural_process.learn_neural_process(few, 1)


def compare(teacher, pupil):
    """Hold a pupil to the teacher: mean close to it, doubt at least as large and near it."""
    mean, std = answers(teacher, speeds(reach=0.4))
    own, spread = answers(pupil, speeds(reach=0.4))
    assert np.sqrt(np.mean((own - mean) ** 2) / np.mean(mean ** 2)) < 0.1
    assert 0.8 < np.exp(np.mean(np.log(spread / std))) < 2.5


def test_e2_6_a_neural_process_learns_from_its_context(monkeypatch):
    monkeypatch.setattr(neural_process, 'STEPS', 500)
    tensors, left = neural_process.learn_neural_process(data(), 1)
    assert relative_error(NetworkDraws(tensors), speeds(reach=0.4)) < 0.5
    assert (left.share < 0.8).all()


def test_e2_2_the_offset_torque_is_the_difference_less_the_mean(folder):
    function = DifferenceFunction(model(), read_difference(folder, model()))
    follower, joints = ModelFollower(model()), JointStream(model().robot)
    before, after = [], []
    for m in stream(NOTHING, 8.0, seed=5):
        sample = joints.joint_state(m.stamp, m.names, m.position, m.velocity, m.effort)
        if sample is None or sample.fresh or m.stamp < 101.0:
            continue
        prediction = follower.update(sample)
        corrected = function.corrected(sample, prediction)
        mean, _ = function.mean_and_variance(sample.q, sample.v, sample.a, sample.temperature)
        np.testing.assert_allclose(corrected.difference, prediction.difference - mean)
        before.append(prediction.difference)
        after.append(corrected.difference)
    assert np.sqrt(np.mean(np.square(after))) < 0.7 * np.sqrt(np.mean(np.square(before)))


def test_e6_4_a_place_never_seen_weighs_less(folder):
    n = model().robot.n

    @dataclass
    class At:
        """A sample with nothing but its motion."""

        q: np.ndarray
        v: np.ndarray
        a: np.ndarray
        temperature: np.ndarray

    function = DifferenceFunction(model(), read_difference(folder, model()))
    zero = np.zeros(n)
    prediction = Prediction(zero, None, None, zero, zero, zero, zero, model().residuals.intensity,
                            1.0)
    near, far = (function.corrected(At(zero, np.full(n, 0.2), zero, np.full(n, celsius)),
                                    prediction).density for celsius in (25.0, 80.0))
    assert (far > 1.5 * near).all()


def test_the_digest_survives_the_file_and_tells_models_apart(tmp_path):
    write_model(tmp_path / 'model.yaml', model())
    assert model_digest(read_model(tmp_path / 'model.yaml')) == model_digest(model())
    assert model_digest(exact_model('four', names=('coulomb_friction',))) != model_digest(model())


def test_e10_1_artefact_is_small_readable_and_bound_to_its_model(folder):
    artefact = read_difference(folder, model())
    assert artefact.inputs == ('velocity', 'temperature')
    assert {path.suffix for path in folder.iterdir()} == {'.safetensors', '.json'}
    assert sum(path.stat().st_size for path in folder.iterdir()) < 1e6
    with pytest.raises(ConfigurationError, match='another torque model.*learn-gp'):
        read_difference(folder, exact_model('four', names=('coulomb_friction',)))


@pytest.mark.parametrize('key, value', [
    ('schema', 'other'), ('joints', ['a']), ('effort_kind', 'link_torque'),
    ('function', 'magic'), ('function', ['gp']), ('inputs', ['colour']), ('inputs', [['gp']])])
def test_a_card_that_does_not_fit_is_refused(folder, tmp_path, key, value):
    card = json.loads((folder / CARD).read_text())
    (tmp_path / CARD).write_text(json.dumps({**card, key: value}))
    (tmp_path / WEIGHTS).write_bytes((folder / WEIGHTS).read_bytes())
    with pytest.raises(ConfigurationError):
        read_difference(tmp_path, model())


def test_tensors_that_do_not_fit_are_refused(folder, tmp_path):
    (tmp_path / CARD).write_text(json.dumps(
        {**json.loads((folder / CARD).read_text()), 'inputs': ['velocity']}))
    (tmp_path / WEIGHTS).write_bytes((folder / WEIGHTS).read_bytes())
    with pytest.raises(ConfigurationError, match='points'):
        read_difference(tmp_path, model())
    (tmp_path / WEIGHTS).write_bytes(b'no tensors')
    with pytest.raises(ConfigurationError, match='holds no learned'):
        read_difference(tmp_path, model())
