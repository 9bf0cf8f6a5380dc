"""The estimate survives a restart through a file, and a file that does not fit is refused."""

from dataclasses import replace
import os

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
import pytest
from safetensors.numpy import load_file

from hand_load_estimator.estimators.checkpoint import (belongs_to, CheckpointError,
                                                       read_checkpoint, restore_checkpoint,
                                                       write_checkpoint)
from hand_load_estimator.estimators.pipeline import CONFIRMED_AFTER

MASS = 3.0


@pytest.fixture(scope='module')
def model():
    return exact_model('four')


@pytest.fixture(scope='module')
def before(model):
    """Return a pipeline that has found the load."""
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, block(MASS), 5.0))
    return pipeline


@pytest.fixture
def path(before, tmp_path):
    """Return the checkpoint of `before`."""
    path = tmp_path / 'state'
    write_checkpoint(path, before.state(), belongs_to(before), now=1000.0)
    return path


def restored(path, pipeline, now=1010.0, max_age=60.0):
    """Return the pipeline gone on from a file."""
    state, age = read_checkpoint(path, belongs_to(pipeline), max_age, now)
    pipeline.restore(state, f'as it was {age:.0f} s before')
    return pipeline


def later(model, load, seconds=4.0, seed=1, **keywords):
    """Return messages after those of `before`."""
    return [replace(m, stamp=m.stamp + 20.0)
            for m in messages(model, load, seconds, seed=seed, **keywords)]


def test_the_estimate_is_there_at_once(model, before, path):
    old, new = before.method.belief(), restored(path, pipeline_of(model)).method.belief()
    std = np.sqrt(np.diag(old.covariance))
    # As exact as Gauss-Newton steps are taken.
    np.testing.assert_allclose(new.mean / std, old.mean / std, atol=1e-3)
    np.testing.assert_allclose(new.covariance / np.outer(std, std),
                               old.covariance / np.outer(std, std), atol=1e-3)


def test_until_motion_it_says_where_it_comes_from(model, before, path):
    pipeline = warm(restored(path, pipeline_of(model)))
    assert pipeline.estimate(0.0).status == 'NO_DATA'
    estimates = feed(pipeline, later(model, block(MASS), rest=1.0))
    still = [e for e in estimates if e.stamp < 120.9]
    assert {e.status for e in still} == {'WAITING_FOR_MOTION'}
    assert all('as it was 10 s before; 0.0 s of motion since' in e.reason for e in still)
    assert not any(e.determined.any() for e in still)
    # Soon after it moves, it is what it was.
    moving = [e for e in estimates if e.stamp > 121.0 + CONFIRMED_AFTER + 0.3]
    assert {e.status for e in moving} == {'DETERMINED'} and pipeline.load_id == 0
    assert abs(estimates[-1].mean[0] - MASS) < 3.5 * estimates[-1].std[0]
    assert estimates[-1].std[0] < 1.05 * before.estimate(0.0).std[0]


@pytest.mark.parametrize('after', [0.0, 1.5])
def test_a_load_exchanged_meanwhile_is_noticed_before_anything_is_determined(model, path, after):
    pipeline = warm(restored(path, pipeline_of(model)))
    estimates = feed(pipeline, later(model, block(after) if after else block(1e-6), rest=0.3))
    changed = [e.stamp - 120.3 for e in estimates if e.load_id > 0]
    assert changed and changed[0] < 1.2 and pipeline.load_id == 1
    assert abs(estimates[-1].mean[0] - after) < 3.5 * estimates[-1].std[0] + 0.01
    said = {e.status for e in estimates if e.load_id == 0}
    assert said == {'WAITING_FOR_MOTION'}
    assert not any('taken as it was' in e.reason for e in estimates if e.load_id == 1)


def test_friction_may_have_drifted_meanwhile(model, before, path):
    """An offset learnt before the outage must not count as known after it."""
    pipeline = restored(path, pipeline_of(model))
    n = model.robot.n
    matrix = pipeline.method.state()['matrix']
    assert not matrix[-3 * n:].any() and not matrix[:, -3 * n:].any()
    assert before.method.state()['matrix'][-3 * n:].any()


def test_tare_and_load_changes_are_kept(model, tmp_path):
    old = warm(pipeline_of(model))
    feed(old, messages(model, block(1.0), 5.0, change=(3.0, block(3.0))))
    old.tare(old.last_stamp)
    write_checkpoint(tmp_path / 'c', old.state(), belongs_to(old), now=1000.0)
    new = restored(tmp_path / 'c', pipeline_of(model))
    assert new.load_id == old.load_id == 1 and new.tared_mass == old.tared_mass
    last = feed(warm(new), later(model, block(3.0)))[-1]
    assert abs(last.mean[0]) < 3.5 * last.std[0]


@pytest.mark.parametrize('key, value, said', [
    ('robot', 'arm 2', 'another robot: chain4, not arm 2'), ('model', 'abc', 'another model'),
    ('method', 'lstm', 'another method: bayes, not lstm'), ('joints', 'a, b', 'another joints')])
def test_what_belongs_elsewhere_is_refused(before, path, key, value, said):
    with pytest.raises(CheckpointError, match=said):
        read_checkpoint(path, {**belongs_to(before), key: value}, 60.0, 1010.0)


@pytest.mark.parametrize('now, said', [(1061.0, '61 s old, more than the 60 s'),
                                       (900.0, '100 s in the future')])
def test_what_is_too_old_is_refused(before, path, now, said):
    with pytest.raises(CheckpointError, match=said):
        read_checkpoint(path, belongs_to(before), 60.0, now)


def test_any_damage_is_found(before, path):
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    damaged = [b'', whole[:5], whole[:len(whole) // 2], whole[:-1], whole + b'x', b'{}' * 99]
    for place in rng.integers(0, len(whole), 60):
        flipped = bytearray(whole)
        flipped[place] ^= 1 << rng.integers(0, 8)
        damaged.append(bytes(flipped))
    for content in damaged:
        path.write_bytes(content)
        with pytest.raises(CheckpointError, match='state'):
            read_checkpoint(path, belongs_to(before), 60.0, 1010.0)


def test_a_state_of_another_shape_changes_nothing(model, before, tmp_path):
    state = {**before.state(), 'vector': np.zeros(3)}
    write_checkpoint(tmp_path / 'c', state, belongs_to(before))
    new = pipeline_of(model)
    prior = new.method.belief()
    with pytest.raises(CheckpointError, match='does not fit: vector'):
        restore_checkpoint(tmp_path / 'c', new, 60.0)
    np.testing.assert_array_equal(new.method.belief().mean, prior.mean)


def test_a_kill_while_writing_leaves_the_old_file(before, path, monkeypatch):
    whole = path.read_bytes()

    def killed(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, 'replace', killed)
    with pytest.raises(KeyboardInterrupt):
        write_checkpoint(path, before.state(), belongs_to(before))
    assert path.read_bytes() == whole and load_file(path)
