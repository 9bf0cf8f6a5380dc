"""The load before a change comes back where torques are its own again and were left out."""

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
from lstm_helpers import artefact_of, network_of, pipeline_with, rounded
import pytest
from test_push_watch import pushed

from hand_load_estimator.estimators.contact_watch import ContactWatch
from hand_load_estimator.estimators.old_load import AGAIN, OldLoads

MASS, FROM = 4.0, 109.0
# [N, Nm] A push that a load could make, and another that begins in it; [s] how long, since when.
DOWN, ASIDE, LASTS, LATE = (0, 0, -40, 0, 0, 0), (40, 0, 0, 0, 0, 0), 1.2, 0.45
UNSURELY = {'surely': False, 'ails': False}


@pytest.fixture(scope='module')
def model():
    return exact_model('ur10e')


@pytest.fixture(scope='module')
def silent(model, tmp_path_factory):
    """Return an artefact whose network says nothing."""
    return artefact_of(tmp_path_factory.mktemp('silent'), model.robot,
                       rounded(network_of(model.robot, size=0.0)))


def test_it_comes_back_soon_after_another_time_where_it_is_seen_again():
    loads = OldLoads()
    loads.keep(10.0, 'first')
    assert loads.back(10.5, **UNSURELY) == 'first'
    loads.keep(11.0, 'second')
    assert loads.back(11.5, **UNSURELY) is None, 'not twice'
    assert loads.again(13.0) == 'second' and loads.again(13.1) is None, 'it is held now'


def test_it_comes_back_as_long_as_contacts_are_left_out():
    loads = OldLoads()
    assert loads.again(1.0) is None
    loads.keep(10.0, 'old')
    assert loads.again(10.0 + AGAIN + 0.1) is None and loads.again(9.0) is None
    assert loads.again(10.0 + AGAIN - 0.1) == 'old'


@pytest.mark.parametrize('method', ['bayes', 'lstm'])
def test_a_push_taken_for_a_load_that_ends_as_a_contact_leaves_the_old_load(
        model, method, silent, monkeypatch):
    """Where none may be taken back, as just after another one that was."""
    monkeypatch.setattr(OldLoads, 'back', lambda self, *arguments: None)
    stream = messages(model, block(MASS), 13.0, seed=2)
    for wrench, begins in (DOWN, FROM), (ASIDE, FROM + LATE):
        stream = pushed(model, stream, wrench, begins, FROM + LASTS)

    def run():
        return feed(warm(pipeline_of(model) if method == 'bayes'
                         else pipeline_with(model, silent)), stream)

    def last_wrong(estimates):
        return max(e.stamp for e in estimates if abs(e.mean[0] - MASS) > 0.1) - FROM

    estimates = run()
    assert any(e.reason.startswith('contact') for e in estimates if e.stamp > FROM + LATE)
    assert last_wrong(estimates) < LASTS + 0.2
    assert abs(estimates[-1].mean[0] - MASS) < 4.0 * estimates[-1].std[0] < 0.1
    monkeypatch.setattr(ContactWatch, 'old_load_again', lambda self, *arguments: False)
    assert last_wrong(run()) > LASTS + 1.0
