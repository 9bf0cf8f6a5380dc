"""Every method goes on from a checkpoint, and from none of another learned artefact."""

from copy import copy, deepcopy
from dataclasses import replace
from functools import lru_cache

from core_helpers import block, exact_model, feed, messages, warm
from difference_helpers import evidence, stream
import direct_helpers
from gp_helpers import LOAD
import lstm_helpers
import numpy as np
import pytest

from hand_load_estimator.estimators.build import build_method, determined_std
from hand_load_estimator.estimators.checkpoint import (belongs_to, CheckpointError,
                                                       restore_checkpoint, write_checkpoint)
from hand_load_estimator.estimators.pipeline import Pipeline
from hand_load_estimator.estimators.registry import DIFFERENCE, METHODS, ON_DIFFERENCE
from hand_load_estimator.learning.direct_design import NETWORKS
from hand_load_estimator.learning.learn_difference import learn_difference
from hand_load_estimator.torque.model_follower import ModelFollower

# Others solve for the answer anew, as exactly as Gauss-Newton steps are taken, and with what has
# been found of the model's agreement since the last sample.
KEEP_THEIR_ANSWER = {*NETWORKS, *ON_DIFFERENCE} - {'gp_bayes'}
# What drifts is found anew there.
OF_REGRESSIONS = ('plain.', 'counted.', 'learned.', 'beside.', 'matrix', 'vector', 'by_joint',
                  'start', 'trust_')
LEARNED = [name for name, way in METHODS.items() if way.learned]


@lru_cache(None)
def model():
    """Return the model of an arm whose torque constants may be off by a hundredth."""
    robot = copy(exact_model('four').robot)
    robot.effort = replace(robot.effort, torque_constants_std=0.01)
    return replace(exact_model('four'), robot=robot)


def pipeline(name, learned):
    """Return a fresh Pipeline of a method."""
    follower = ModelFollower(model())
    method = build_method(model(), follower.uncertainties, name, learned)
    return warm(Pipeline(model(), follower, method, determined_std(model().robot)))


def learn(folder, way, seed):
    """Write what a Way has learned for the arm, another thing for another seed."""
    robot = model().robot
    if way.learned == DIFFERENCE:
        learn_difference(folder, model(), evidence()[:seed], names=('velocity',))
    elif way.learned == 'lstm':
        lstm_helpers.artefact_of(folder, robot, lstm_helpers.network_of(robot, seed))
    else:
        design = direct_helpers.design_of(robot, way.learned)
        direct_helpers.artefact_of(folder, robot, direct_helpers.network_of(robot, design, seed))


@pytest.fixture(scope='module')
def learned(tmp_path_factory):
    """Return learned(name, seed=2): the folder of a method's artefact, or None."""
    folders = {}

    def folder(name, seed=2):
        way = METHODS[name]
        if way.learned is None:
            return None
        if (way.learned, seed) not in folders:
            folders[way.learned, seed] = tmp_path_factory.mktemp(way.learned)
            learn(folders[way.learned, seed], way, seed)
        return folders[way.learned, seed]

    return folder


@pytest.fixture(scope='module')
def found(learned):
    """Return found(name): a Pipeline of a method that has found the load."""
    pipelines = {}

    def of(name):
        if name not in pipelines:
            pipelines[name] = pipeline(name, learned(name))
            feed(pipelines[name], arm(name, LOAD, 2.5, seed=7))
        return pipelines[name]

    return of


def gone_on(old, new, folder):
    """Return the new Pipeline, gone on from a checkpoint of the old one."""
    write_checkpoint(folder / 'c', old.state(), belongs_to(old))
    restore_checkpoint(folder / 'c', new, 60.0)
    return new


def arm(name, load, seconds, **options):
    """Return Messages of an arm that the method's model or learned function is right about."""
    if name in ON_DIFFERENCE:
        return stream(load, seconds, **options)
    return messages(model(), load, seconds, **options)


def later(name, load, seconds=1.5):
    """Return Messages of the arm after an outage."""
    return [replace(m, stamp=m.stamp + 20.0)
            for m in arm(name, load, seconds, seed=8, rest=0.3)]


def assert_same(name, after, before):
    """Compare two Beliefs in units of the standard deviation."""
    std, atol = np.sqrt(np.diag(before.covariance)), 1e-9 if name in KEEP_THEIR_ANSWER else 1e-2
    np.testing.assert_allclose(after.mean / std, before.mean / std, atol=atol)
    np.testing.assert_allclose(after.covariance / np.outer(std, std),
                               before.covariance / np.outer(std, std), atol=atol)


@pytest.mark.parametrize('name', METHODS)
def test_the_belief_is_there_at_once(name, found, learned, tmp_path):
    fresh = pipeline(name, learned(name))
    prior, before = fresh.method.belief(), found(name).method.belief()
    assert_same(name, gone_on(found(name), fresh, tmp_path).method.belief(), before)
    assert np.abs(before.mean - prior.mean)[0] > 0.01, 'there was nothing to keep'


@pytest.mark.parametrize('name', METHODS)
def test_with_new_data_it_goes_on_as_after_a_gap(name, found, learned, tmp_path):
    unbroken, fresh = deepcopy(found(name)), pipeline(name, learned(name))
    new = gone_on(unbroken, pipeline(name, learned(name)), tmp_path)
    before = new.method.belief()
    after, wanted, anew = (feed(made, later(name, LOAD)) for made in (new, unbroken, fresh))
    assert (np.abs(after[-1].mean - wanted[-1].mean) < 0.5 * wanted[-1].std).all()
    assert new.load_id == 0
    if name in NETWORKS:
        # Only at first: what these untrained ones remember fades in a second.
        off, forgotten = (np.abs(one[0].mean - wanted[0].mean).max() for one in (after, anew))
        assert off < 0.05 * forgotten
    else:
        assert after[-1].std[0] < np.sqrt(before.covariance[0, 0])
        assert after[-1].std[0] < 0.6 * anew[-1].std[0]


@pytest.mark.parametrize('name', METHODS)
def test_a_load_exchanged_meanwhile_is_noticed(name, found, learned, tmp_path):
    new = gone_on(found(name), pipeline(name, learned(name)), tmp_path)
    estimates = feed(new, later(name, block(0.5)))
    assert new.load_id == 1
    if name not in NETWORKS:
        assert abs(estimates[-1].mean[0] - 0.5) < 0.1


@pytest.mark.parametrize('name', METHODS)
def test_what_was_tared_and_its_doubt_are_kept(name, found, learned, tmp_path):
    old = deepcopy(found(name))
    old.method.tare()
    feed(old, [m for m in arm(name, LOAD, 4.0, seed=7) if m.stamp > old.last_stamp])
    new = gone_on(old, pipeline(name, learned(name)), tmp_path)
    assert_same(name, new.method.belief(), old.method.belief())
    assert new.tared_mass == old.tared_mass == pytest.approx(LOAD.mass, abs=0.1)
    kept = new.method.state()
    for key, value in old.method.state().items():
        if not key.startswith(OF_REGRESSIONS):
            np.testing.assert_array_equal(kept[key], value, key)
    after, wanted = (feed(made, later(name, LOAD, 0.5))[-1] for made in (new, old))
    assert (np.abs(after.mean - wanted.mean) < 0.5 * wanted.std).all()
    np.testing.assert_allclose(after.std, wanted.std, rtol=0.3)


@pytest.mark.parametrize('name', METHODS)
def test_what_has_seen_nothing_yet_begins_as_any_other(name, learned, tmp_path):
    new, other, fresh = (pipeline(name, learned(name)) for _ in range(3))
    gone_on(fresh, new, tmp_path)
    for after, wanted in zip(*(feed(made, later(name, LOAD, 0.5)) for made in (new, other))):
        np.testing.assert_allclose(after.mean, wanted.mean, atol=1e-9)
        np.testing.assert_allclose(after.std, wanted.std, rtol=1e-6)


@pytest.mark.parametrize('name', METHODS)
def test_a_state_that_does_not_fit_changes_nothing(name, found, learned):
    state, method = found(name).method.state(), pipeline(name, learned(name)).method
    before = method.state()
    for key, value in state.items():
        changed = [{**state, key: np.zeros((*value.shape, 2))},
                   {**state, key: np.full(value.shape, np.nan)},
                   {k: v for k, v in state.items() if k != key}]
        for wrong in changed:
            with pytest.raises(ValueError, match='not of shape|is missing|from another learned'):
                method.restore(wrong)
    for key, value in method.state().items():
        np.testing.assert_array_equal(value, before[key])


@pytest.mark.parametrize('name', METHODS)
def test_a_state_stays_as_it_was_while_the_method_goes_on(name, found):
    """A node writes it in a thread of its own."""
    going_on = deepcopy(found(name))
    state = going_on.method.state()
    before = deepcopy(state)
    feed(going_on, later(name, LOAD, 0.8))
    for key, value in before.items():
        np.testing.assert_array_equal(state[key], value, key)


@pytest.mark.parametrize('name', LEARNED)
def test_a_checkpoint_belongs_to_what_was_learned(name, found, learned, tmp_path):
    with pytest.raises(CheckpointError, match='does not fit: it comes from another learned'):
        gone_on(found(name), pipeline(name, learned(name, seed=1)), tmp_path)


def test_the_first_sample_is_judged_by_the_same_candidates(found, learned, tmp_path):
    """After it they are weighed anew anyway."""
    old, new = found('gp_histogram'), pipeline('gp_histogram', learned('gp_histogram'))
    gone_on(old, new, tmp_path)
    for name in ('_products', '_data', '_from_prior'):
        np.testing.assert_array_equal(getattr(new.method, name), getattr(old.method, name))
