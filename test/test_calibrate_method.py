"""`hand_load calibrate`: 95 % of methods without a network made true on held-out draws."""

from dataclasses import replace
import json
import shutil

from core_helpers import block, CALIBRATED, exact_model, feed, four_axes, messages, warm
import numpy as np
import pytest
from ros_helpers import ROOT
from safetensors.numpy import load_file, save_file
import torch

from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators import build, regression
from hand_load_estimator.estimators.build import build_method, build_pipeline, shipped_intervals
from hand_load_estimator.estimators.calibrated import Calibrated
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.estimators.model_trust import ModelTrust
from hand_load_estimator.estimators.pipeline import Pipeline
from hand_load_estimator.learning import shards
from hand_load_estimator.learning.artefact import arm_of
from hand_load_estimator.learning.calibrate_method import (calibrate_method, CalibrationRecipe,
                                                           MethodAnswers)
from hand_load_estimator.learning.drawn_stream import drawn_stream
from hand_load_estimator.learning.intervals import (Intervals, kind_of, origin_of, read_intervals,
                                                    write_intervals)
from hand_load_estimator.learning.objective import answers, JUDGED
from hand_load_estimator.learning.sequences import SequenceMaker
from hand_load_estimator.learning.shards import make_shard, prior_tensors
from hand_load_estimator.learning.stated_factors import RANGES
from hand_load_estimator.torque.model_file import write_model
from hand_load_estimator.torque.model_follower import ModelFollower

RECIPE = CalibrationRecipe('bayes', calibration=4, validation=2)


class Killed(Exception):
    """The end of a calibration in mid course."""


@pytest.fixture(scope='module')
def model():
    return exact_model('four', doubt=0.02)


@pytest.fixture(scope='module')
def made(tmp_path_factory, model):
    """Return folder with a model, a calibration undisturbed and one that was broken off."""
    out = tmp_path_factory.mktemp('calibrated')
    write_model(out / 'model.yaml', model)

    def killed(text):
        if text.startswith('sequences (calibration) 1/'):
            raise Killed

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shards, 'BATCH', 2)
        with pytest.raises(Killed):
            calibrate_method(out / 'model.yaml', out / 'again', RECIPE, killed)
        kept = list((out / 'again' / 'work').rglob('*.safetensors'))
        for name in ('again', 'whole'):
            calibrate_method(out / 'model.yaml', out / name, RECIPE, print)
    return out, kept


def intervals_of(factor, knots=None):
    knots = np.tile(np.arange(RANGES, dtype=float), (10, 1)) if knots is None else knots
    return Intervals(knots, np.full((10, RANGES), factor))


def written(folder, robot, factor=2.0, method='bayes'):
    write_intervals(folder, intervals_of(factor), {
        **arm_of(robot), 'network': kind_of(method), 'recipe': {'method': method}})
    return folder


def test_a_method_sees_of_a_draw_what_training_does(model, monkeypatch):
    """The plain regression over a batch, and `bayes` sample by sample, answer the same."""
    monkeypatch.setattr(regression, 'MEMORY', 1e12)
    monkeypatch.setattr(ModelTrust, 'look', lambda *arguments: None)
    maker = SequenceMaker(model)
    healthy = next(s for s in range(20) if not maker.make(s).severe)
    seen = MethodAnswers('bayes', None)(maker, model.robot, [healthy])
    shard = make_shard(maker, model.robot, [healthy])
    mean, variance, _ = answers(None, shard, *prior_tensors(model.robot))
    error = (mean - shard['load'][:, None].double()).numpy()[0]
    known = np.isfinite(seen['error'][0].numpy())
    std = torch.sqrt(variance)[0].numpy()
    assert known.mean() > 0.5 and len(JUDGED) == len(error)
    np.testing.assert_allclose((seen['error'][0].numpy() / std)[known], (error / std)[known],
                               atol=0.05)
    np.testing.assert_allclose(seen['std'][0].numpy()[known], std[known], rtol=0.05)


def test_a_drawn_stream_carries_the_sequence(model):
    sequence = SequenceMaker(model).make(3)
    stream = list(drawn_stream(model.robot, sequence))
    assert len(stream) == len(sequence.motion)
    sample, prediction = stream[40]
    np.testing.assert_array_equal(sample.v, sequence.motion[40, 1])
    np.testing.assert_allclose(sample.temperature - model.robot.reference_temperature,
                               sequence.warmth[40], atol=1e-5)
    columns = np.hstack([prediction.load_columns,
                         prediction.model_columns * prediction.column_scale])
    np.testing.assert_array_equal(columns, sequence.columns[40])
    assert (prediction.stuck >= 0.0).all() and stream[41][0].stamp > sample.stamp


def test_factors_come_on_deviations_and_leave_correlations(model):
    follower = ModelFollower(model)
    plain = build_method(model, follower.uncertainties, 'bayes')
    knots = np.tile(np.linspace(-9.0, -1.0, RANGES), (10, 1))
    factors = np.ones((10, RANGES))
    factors[0], factors[5] = 3.0, 0.5
    ours = Calibrated(plain, Intervals(knots, factors), model)
    np.testing.assert_array_equal(ours.belief().covariance, plain.belief().covariance)
    stream = messages(exact_model('four'), block(2.0), 1.5)
    pipeline = Pipeline(model, follower, ours, build.determined_std(model.robot))
    feed(warm(pipeline), stream)
    one, other = plain.belief(), ours.belief()
    np.testing.assert_array_equal(one.mean, other.mean)
    wanted = np.ones(10)
    wanted[0], wanted[5] = 3.0, 0.5
    np.testing.assert_allclose(other.covariance, one.covariance * np.outer(wanted, wanted))
    assert (ours.name, ours.changes, ours.mismatch) == ('bayes', 0, '')
    with pytest.raises(AttributeError):
        ours.reliability


def test_what_is_surer_has_its_own_factor(model):
    class Stated:
        """A method that states one deviation of everything."""

        name, std = 'bayes', 10.0

        def state(self):
            return {}

        def belief(self):
            return Belief(np.zeros(10), self.std ** 2 * np.eye(10))

    factors = np.tile(np.linspace(1.0, 2.0, RANGES), (10, 1))
    intervals = Intervals(np.tile(np.linspace(-5.0, 0.0, RANGES), (10, 1)), factors)
    method = Stated()
    ours = Calibrated(method, intervals, model)
    # The last two: half way, in e-folds of the mass, to what is believed before any data; there.
    for std, factor in ((np.exp(-2.5), 1.5), (1e-9, 1.0), (1.0, 2.0), (10.0 ** 0.5, 2.0 ** 0.5),
                        (10.0, 1.0)):
        method.std = std
        np.testing.assert_allclose(np.sqrt(np.diag(ours.belief().covariance)), factor * std)


def test_a_calibration_broken_off_goes_on_and_ends_as_an_undisturbed_one(made):
    out, kept = made
    assert len(kept) >= 1
    whole, again = (load_file(out / name / 'intervals.safetensors') for name in ('whole', 'again'))
    for name in ('knots', 'factors'):
        np.testing.assert_array_equal(whole[name], again[name])
        assert whole[name].shape == (10, RANGES)


def test_E10_1_the_folder_is_all_that_is_handed_over(made):
    folder = made[0] / 'whole'
    assert sorted(p.name for p in folder.rglob('*')) == ['card.json', 'intervals.safetensors']
    card = json.loads((folder / 'card.json').read_text())
    assert card['network'] == 'intervals of bayes'
    assert card['recipe']['calibration'] == RECIPE.calibration
    assert set(card['held_out']) >= {'coverage_of_95', 'coverage_of_95_as_stated',
                                     'coverage_of_95_over_time'}


def test_the_estimator_states_them_and_finds_the_same_load(made):
    """Published deviations are the plain ones times the factors that the folder holds."""
    out, stream = made[0], messages(exact_model('four'), block(2.0), 1.5)
    said = [feed(warm(build_pipeline(out / 'model.yaml', 'bayes', intervals=folder)), stream)[-1]
            for folder in (None, str(out / 'whole'))]
    np.testing.assert_allclose(said[0].mean, said[1].mean)
    factors = load_file(out / 'whole' / 'intervals.safetensors')['factors']
    ratio = said[1].std / said[0].std
    least, most = (np.minimum(factors.min(axis=1), 1.0), np.maximum(factors.max(axis=1), 1.0))
    assert (ratio > 0.99 * least).all() and (ratio < 1.01 * most).all()
    assert np.abs(ratio - 1.0).max() > 0.01


def test_which_intervals_are_at_work_is_told(made, model):
    """And where they were made around another model, or without what was learned since."""
    out = made[0]
    plain, ours = (build_pipeline(out / 'model.yaml', 'bayes', intervals=folder).intervals
                   for folder in (None, str(out / 'whole')))
    assert (plain, ours) == ('as the method has them', 'whole')
    intervals = read_intervals(out / 'whole', model.robot, 'bayes')
    assert intervals.told({**intervals.origin, 'model': 'x'}) \
        == 'whole, made with another torque model'
    assert intervals.told({'model': 'x', 'function': [1.0]}) \
        == 'whole, made with another torque model and learned torque difference'


@pytest.mark.parametrize('method', CALIBRATED)
def test_those_shipped_are_taken_by_themselves_and_by_name(method):
    name = f'ur10e_{method}_intervals'
    assert build_pipeline('ur10e', method, intervals=name).intervals == name
    assert build_pipeline('ur10e', method).intervals == name


def test_none_are_shipped_that_make_a_method_worse():
    assert build_pipeline('ur10e', 'least_squares').intervals == 'as the method has them'


def test_a_card_that_names_no_model_is_told_as_that(tmp_path):
    intervals = read_intervals(written(tmp_path, four_axes()), four_axes(), 'bayes')
    assert intervals.told({'model': 'x', 'function': None}).endswith(
        'whose card does not name the torque model they were made with')


def test_a_checkpoint_goes_from_stated_to_calibrated_intervals_and_back(made):
    out, stream = made[0], messages(exact_model('four'), block(2.0), 1.5)
    plain, ours = (warm(build_pipeline(out / 'model.yaml', 'bayes', intervals=folder))
                   for folder in (None, str(out / 'whole')))
    feed(plain, stream)
    ours.restore(plain.state(), 'restored')
    fresh = warm(build_pipeline(out / 'model.yaml', 'bayes'))
    fresh.restore(ours.state(), 'restored')
    np.testing.assert_allclose(fresh.method.belief().mean, ours.method.belief().mean, rtol=1e-3)


def test_those_of_another_model_are_taken_when_asked_for_only(tmp_path, model, monkeypatch):
    """Of the same arm, too: a user's model keeps what the method states unless told."""
    monkeypatch.setattr(build, 'share_folder', lambda: tmp_path)
    folder = written(tmp_path / 'config' / 'learned' / 'four_bayes', model.robot)
    size = ModelFollower(model).uncertainties

    def std(method):
        return np.sqrt(np.diag(method.belief().covariance))

    plain_method = build_method(model, size, 'bayes')
    assert shipped_intervals(model, plain_method) is None
    own = replace(intervals_of(2.0), origin=origin_of(model, plain_method))
    card = json.loads((folder / 'card.json').read_text())
    write_intervals(tmp_path / 'config' / 'learned' / 'own', own, card)
    assert shipped_intervals(model, plain_method) == tmp_path / 'config' / 'learned' / 'own'
    write_model(tmp_path / 'model.yaml', model)
    assert build_pipeline(tmp_path / 'model.yaml', 'bayes').intervals == 'own'
    assert build_pipeline(tmp_path / 'model.yaml', 'least_squares').intervals \
        == 'as the method has them'
    plain = std(build_method(model, size, 'bayes'))
    np.testing.assert_array_equal(std(build_method(model, size, 'bayes')), plain)
    assert not isinstance(build_method(model, size, 'bayes'), Calibrated)
    # A network that is not there becomes `bayes`, with what is asked for of that.
    for name in ('bayes', 'lstm'):
        assert isinstance(build_method(model, size, name, intervals=str(folder)), Calibrated)


def test_a_calibration_does_not_go_on_with_another_learned_function(tmp_path, monkeypatch):
    """Sequences of the old one, learned over since, were mixed with those of the new one."""
    def killed(*arguments):
        raise Killed

    monkeypatch.setattr('hand_load_estimator.learning.calibrate_method.make_sequences', killed)
    model, learned = (ROOT / 'config' / name for name in ('models/ur10e.yaml', 'learned/ur10e_gp'))
    shutil.copytree(learned, tmp_path / 'gp')
    recipe = CalibrationRecipe('gp_bayes', str(tmp_path / 'gp'), calibration=2, validation=2)
    for _ in range(2):
        with pytest.raises(Killed):
            calibrate_method(model, tmp_path / 'out', recipe)
    tensors = load_file(learned / 'difference.safetensors')
    save_file({**tensors, 'gain': 0.5 * tensors['gain']},
              tmp_path / 'gp' / 'difference.safetensors')
    with pytest.raises(ConfigurationError, match='another learned torque difference'):
        calibrate_method(model, tmp_path / 'out', recipe)


@pytest.mark.parametrize('how', ['method', 'joints', 'a NaN', 'factors of nothing', 'shape'])
def test_what_does_not_belong_or_is_damaged_is_refused(tmp_path, how):
    robot = four_axes()
    written(tmp_path, robot)
    card = json.loads((tmp_path / 'card.json').read_text())
    tensors = {k: v.copy() for k, v in load_file(tmp_path / 'intervals.safetensors').items()}
    if how == 'method':
        card['network'] = kind_of('least_squares')
    elif how == 'joints':
        card['joints'] = ['a', 'b', 'c', 'd']
    elif how == 'a NaN':
        tensors['knots'][0, 0] = np.nan
    elif how == 'shape':
        tensors['factors'] = tensors['factors'][:4]
    else:
        tensors['factors'][:] = 0.0
    (tmp_path / 'card.json').write_text(json.dumps(card))
    save_file(tensors, tmp_path / 'intervals.safetensors')
    with pytest.raises(ConfigurationError) as caught:
        read_intervals(tmp_path, robot, 'bayes')
    assert str(tmp_path) in str(caught.value)


@pytest.mark.parametrize('method', ['lstm', 'gru'])
def test_intervals_given_as_what_was_learned_are_told_where_they_go(tmp_path, method):
    with pytest.raises(ConfigurationError, match='give it as `intervals`, with method bayes'):
        build_method(exact_model('four'), 0, method, str(written(tmp_path, four_axes())))


def test_a_network_brings_its_own(tmp_path):
    with pytest.raises(ConfigurationError, match='brings its own'):
        build_pipeline('ur10e', 'lstm', intervals=str(written(tmp_path, four_axes())))


@pytest.mark.parametrize('method, said', [('gru', 'bayes, least_squares, gp_histogram'),
                                          ('magic', 'bayes, least_squares'),
                                          ('gp_bayes', 'learned torque difference')])
def test_wrong_choices_end_with_two_and_a_line(made, tmp_path, capsys, method, said):
    status = main(['calibrate', '--model', str(made[0] / 'model.yaml'), '--method', method,
                   '--out', str(tmp_path / 'out')])
    assert status == 2 and said in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def test_the_command_tells_progress_and_coverage(made, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(shards, 'BATCH', 4)
    monkeypatch.setattr('hand_load_estimator.learning.calibrate_method.CalibrationRecipe',
                        lambda method, learned: CalibrationRecipe(method, learned, 4, 4))
    out = tmp_path / 'out'
    assert main(['calibrate', '--model', str(made[0] / 'model.yaml'), '--method',
                 'least_squares', '--out', str(out)]) == 0
    said = capsys.readouterr().out
    assert 'min left' in said and 'coverage_of_95_as_stated' in said
    assert read_intervals(out, four_axes(), 'least_squares').factors.shape == (10, RANGES)
