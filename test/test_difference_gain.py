"""How much of a learned torque difference is subtracted: what recordings left out say of it."""

from dataclasses import replace
import json

from difference_helpers import data, evidence, model, speeds
import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from hand_load_estimator.estimators.difference_function import DifferenceFunction
from hand_load_estimator.estimators.inducing_points import InducingPoints
from hand_load_estimator.learning import torque_gp
from hand_load_estimator.learning.difference_artefact import CARD, read_difference, WEIGHTS
from hand_load_estimator.learning.difference_data import DifferenceData
from hand_load_estimator.learning.learn_difference import learn_difference
from hand_load_estimator.learning.left_out import left_out


@pytest.fixture(scope='module')
def learned(tmp_path_factory):
    """Return (folder, LeftOut) of an artefact of velocity."""
    folder = tmp_path_factory.mktemp('gain')
    return folder, learn_difference(folder, model(), evidence(), names=('velocity',))


def test_e2_1_a_joint_with_nothing_to_learn_is_left_alone_and_the_others_are_not():
    difference = data().difference.copy()
    difference[:, 1] = np.random.default_rng(1).normal(size=len(difference))
    tensors, result = torque_gp.learn_gp(replace(data(), difference=difference), 1)
    mean, _ = InducingPoints(tensors).at(data().inputs)
    real = np.arange(model().robot.n) != 1
    assert (result.gain[real] > 0.95).all() and (result.share[real] < 0.5).all()
    # A share of nearly nothing may be anything; what is subtracted must be small beside the noise.
    assert np.sqrt(np.mean((result.gain * mean)[:, 1] ** 2)) < 0.05 and result.share[1] < 1.01


def by_hand(difference, owner):
    """Return DifferenceData of one joint whose inputs are its difference."""
    difference = np.asarray(difference, dtype=float)[:, None]
    return DifferenceData(('velocity',), difference[..., None], difference, np.ones(1),
                          np.ones_like(difference), np.asarray(owner), np.full(len(owner), 0.02))


@pytest.mark.parametrize('owner', [np.repeat(np.arange(7), 80), np.zeros(560, dtype=int)])
@pytest.mark.parametrize('right, gain', [(1.0, 1.0), (2.0, 0.5), (0.8, 1.0), (-1.0, 0.0)])
def test_the_gain_makes_the_best_of_an_answer_and_drops_a_wrong_one(owner, right, gain):
    """A function that answers `right` times the truth; many recordings, or one cut in time."""
    waves = 3.0 * np.sin(np.arange(len(owner)) / 20.0)
    result = left_out(by_hand(waves, owner), lambda rows: lambda x: (
        right * x[..., 0], np.full(x.shape[:2], 0.01)))
    assert result.gain == pytest.approx(gain, abs=0.01)
    assert result.share == pytest.approx((1.0 - gain * right) ** 2, abs=0.01)
    # What the function says and is not subtracted is left in the torque.
    assert result.variance == pytest.approx(
        0.01 + ((1.0 - gain) * right) ** 2 * np.mean(waves ** 2), rel=0.05)


def test_a_recording_is_judged_with_a_gain_that_has_not_seen_it():
    """Without the first recording all is learned upside down: judging it, that must be known."""
    owner = np.repeat(np.arange(3), 80)

    def learn(rows):
        sign = 1.0 if rows[0] else -1.0
        return lambda x: (sign * x[..., 0], np.zeros(x.shape[:2]))

    result = left_out(by_hand(np.ones(240), owner), learn)
    # Two of three recordings are answered rightly, which no two of them show.
    assert result.gain == pytest.approx(1.0 / 3.0, abs=0.01)
    assert result.share == pytest.approx(1.0, abs=1e-9)


def test_where_nothing_is_subtracted_the_residual_is_as_before():
    """Learned from one recording all is right, from two all is wrong."""
    def learn(rows):
        sign = 1.0 if rows.sum() == 80 else -1.0
        return lambda x: (sign * x[..., 0], np.zeros(x.shape[:2]))

    result = left_out(by_hand(np.ones(240), np.repeat(np.arange(3), 80)), learn)
    assert result.gain == 0.0 and result.share == 1.0


@pytest.mark.parametrize('recordings, times', [(5, 5 + 10), (20, 20 + 20 * 4)])
def test_leaving_out_twice_costs_no_square_of_the_recordings(recordings, times):
    learned = []

    def learn(rows):
        learned.append(rows.tobytes())
        return lambda x: (x[..., 0], np.zeros(x.shape[:2]))

    left_out(by_hand(np.ones(40 * recordings), np.repeat(np.arange(recordings), 40)), learn)
    assert len(learned) == len(set(learned)) <= times


def test_the_gain_survives_the_file_and_scales_what_is_subtracted(learned):
    folder, told = learned
    artefact = read_difference(folder, model())
    np.testing.assert_allclose(artefact.gain, told.gain, rtol=1e-6)
    assert (artefact.gain > 0.9).all()
    assert artefact.card['gain'] == pytest.approx(told.gain, abs=1e-4)
    half = replace(artefact, gain=np.array([1.0, 0.5, 0.0, 1.0]))
    v, nothing = speeds(9), np.zeros((9, model().robot.n))
    (mean, variance), (used, about) = (
        DifferenceFunction(model(), found).mean_and_variance(nothing, v, nothing, nothing)
        for found in (replace(artefact, gain=np.ones(4)), half))
    np.testing.assert_allclose(used, half.gain * mean)
    np.testing.assert_allclose(about, variance + ((1.0 - half.gain) * mean) ** 2)


def test_an_artefact_that_tells_no_gain_is_subtracted_whole(learned, tmp_path):
    folder, _ = learned
    tensors, card = load_file(folder / WEIGHTS), json.loads((folder / CARD).read_text())
    del tensors['gain'], card['gain']
    save_file(tensors, tmp_path / WEIGHTS)
    (tmp_path / CARD).write_text(json.dumps(card))
    np.testing.assert_array_equal(read_difference(tmp_path, model()).gain, np.ones(4))
