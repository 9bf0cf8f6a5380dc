"""A push on the hand is kept out of the estimate; another load is not."""

from dataclasses import replace

from core_helpers import block, exact_model, feed, longest_contact, messages, pipeline_of, warm
import numpy as np
import pytest

from hand_load_estimator.estimators.contact_gate import ContactGate, LONGEST
from hand_load_estimator.load import LoadParameters

MASS, FROM, TO = 2.0, 104.0, 105.0


@pytest.fixture(scope='module')
def model():
    return exact_model('ur10e')


def pushed(model, stream, force, first=FROM, last=TO):
    """Return Messages with a force (3,) [N] on the hand, in base axes, for a while."""
    robot, out = model.robot, []
    for m in stream:
        share = np.clip(min(m.stamp - first, last - m.stamp) / 0.05, 0.0, 1.0)
        torque = -robot.hand_jacobian(m.position).T @ (share * np.asarray(force))
        out.append(replace(m, effort=m.effort + torque))
    return out


@pytest.mark.parametrize('force', [(40.0, 0.0, 0.0), (20.0, -30.0, 20.0)])
def test_a_push_is_told_and_leaves_no_trace(model, force):
    stream = messages(model, block(MASS), 7.0)
    plain = feed(warm(pipeline_of(model)), stream)
    pipeline = warm(pipeline_of(model))
    estimates = feed(pipeline, pushed(model, stream, force))
    during = [e for e in estimates if FROM + 0.2 < e.stamp < TO - 0.1]
    assert np.mean([e.status == 'MODEL_MISMATCH' for e in during]) > 0.9
    assert all('contact' in e.reason for e in during if e.status == 'MODEL_MISMATCH')
    assert pipeline.load_id == 0 and estimates[-1].status == 'DETERMINED'
    std = plain[-1].std[:4]
    assert (np.abs(estimates[-1].mean - plain[-1].mean)[:4] < 2.0 * std).all()
    worst = max(np.abs(e.mean[0] - MASS) for e in during)
    assert worst < 5.0 * next(e for e in plain if e.stamp > FROM).std[0]


@pytest.mark.parametrize('gated', [True, False])
def test_a_push_on_a_standing_arm_is_no_load(model, gated, monkeypatch):
    """Friction takes a part of it; what is left belongs to no load."""
    if not gated:
        monkeypatch.setattr(ContactGate, 'update', lambda *_: False)
        monkeypatch.setattr(ContactGate, 'refuses', lambda *_: False)
    stream = messages(model, block(MASS), 4.0, rest=9.0)
    pipeline = warm(pipeline_of(model))
    feed(pipeline, pushed(model, stream, (60.0, 60.0, 0.0), 102.0, 103.5))
    assert pipeline.load_id == 0 if gated else pipeline.load_id > 0


def test_a_push_first_taken_for_a_load_is_taken_back(model):
    """A weight for half a second that then pulls sideways was no load: the old one is back."""
    alone, more = (messages(model, block(mass), 7.0) for mass in (MASS, 3.0 * MASS))
    stream = [o if FROM < m.stamp < TO else m for m, o in zip(alone, more)]
    pipeline = warm(pipeline_of(model))
    estimates = feed(pipeline, pushed(model, stream, (60.0, 0.0, 0.0), FROM + 0.5, TO))
    changes = [e.load_id for e in estimates]
    assert changes[-1] == 2, 'one that was none, and back'
    back = next(e for e in estimates if e.load_id == 2)
    assert back.stamp < TO and abs(back.mean[0] - MASS) < 4.0 * back.std[0] + 0.05
    assert abs(estimates[-1].mean[0] - MASS) < 4.0 * estimates[-1].std[0]


@pytest.mark.parametrize('before, after', [(0.0, 10.0), (10.0, 0.0), (3.0, 5.0)])
def test_another_load_is_not_locked_out(model, before, after):
    loads = [block(mass) if mass else LoadParameters() for mass in (before, after)]
    pipeline = warm(pipeline_of(model))
    estimates = feed(pipeline, messages(model, loads[0], 6.0, change=(3.0, loads[1])))
    assert pipeline.load_id == 1
    assert next(e.stamp for e in estimates if e.load_id) < 103.0 + 1.2
    assert abs(estimates[-1].mean[0] - after) < 3.5 * estimates[-1].std[0] + 0.01
    assert not any('contact' in e.reason for e in estimates)


def test_another_load_that_the_model_misreads_is_found(model):
    """All joints report a tenth more of the new load than it weighs on them, some a tenth less."""
    gain = 1.0 + 0.1 * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    stream = messages(model, LoadParameters(), 6.0)
    loaded = messages(model, LoadParameters(), 6.0, change=(3.0, block(8.0)))
    mixed = [replace(m, effort=m.effort + gain * (o.effort - m.effort))
             for m, o in zip(stream, loaded)]
    estimates = feed(warm(pipeline_of(model)), mixed)
    assert abs(estimates[-1].mean[0] - 8.0) < 1.5


@pytest.mark.parametrize('seed', range(3))
def test_a_contact_that_never_ends_is_told_for_eight_seconds_at_a_time(model, seed):
    stream = messages(model, block(MASS), 24.0, seed=seed)
    estimates = feed(warm(pipeline_of(model)),
                     pushed(model, stream, (40.0, 0.0, 0.0), 103.0, 200.0))
    stamps = np.array([e.stamp for e in estimates])
    told = np.array(['contact' in e.reason for e in estimates])
    assert told[(stamps > 103.2) & (stamps < 110.5)].all()
    # A load may explain the push for a moment, and what follows counts anew.
    assert longest_contact(estimates) < LONGEST + 0.1


def test_what_is_always_unexplained_is_no_contact(model):
    """A joint whose torque is wrong all the time is a misfit of the model, and said to be."""
    stream = [replace(m, effort=m.effort + np.array([0, 0, 0, 0, 0, 8.0]) * np.sin(9.0 * m.stamp))
              for m in messages(model, block(MASS), 16.0)]
    estimates = feed(warm(pipeline_of(model)), stream)
    late = [e.reason for e in estimates if e.stamp > 112.0]
    assert any('lasting misfit' in reason for reason in late)
    assert np.mean(['contact' in reason for reason in late]) < 0.1


def test_a_wrong_model_is_no_contact_from_the_start(model):
    """The load is estimated, wrongly, and not held back as if somebody pushed."""
    stream = [replace(m, effort=m.effort + np.array([0, 20.0, 0, 0, 0, 0]))
              for m in messages(model, block(MASS), 4.0)]
    first, *_, last = feed(warm(pipeline_of(model)), stream)
    assert last.std[0] < 0.2 * first.std[0] and 'contact' not in last.reason


@pytest.mark.parametrize('seed', range(3))
def test_nothing_is_left_out_on_a_right_model(model, seed):
    pipeline = warm(pipeline_of(model))
    estimates = feed(pipeline, messages(model, block(4.0), 8.0, seed=seed))
    assert not any(e.status == 'MODEL_MISMATCH' for e in estimates)
