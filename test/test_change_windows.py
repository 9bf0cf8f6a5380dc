"""Every sample may show another load; what a window holds, and what is asked of it."""

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
from lstm_helpers import artefact_of, network_of, pipeline_with, rounded
import numpy as np
import pytest

from hand_load_estimator.estimators import change_windows, regression
from hand_load_estimator.estimators.change import (BRIEF, EVIDENCE, LONG, MIDDLE, RecentData,
                                                   SHORT, SLIP, slip_covariance)
from hand_load_estimator.estimators.change_windows import ChangeWindows, Older
from hand_load_estimator.estimators.model_trust import ModelTrust
from hand_load_estimator.load import LoadParameters, products_and_jacobian_of_shape


def first_told(pipeline, stream):
    """Return the stamp [s] of the first estimate that tells another load."""
    return next(e.stamp for e in feed(warm(pipeline), stream) if e.load_id > 0)


def delays_of_slips(count=6):
    """Return [s] from slips of 0.1 kg m to the estimate that tells them, in a moving arm."""
    model, out = exact_model('ur10e'), []
    for seed in range(count):
        held, way = block(4.0), np.random.default_rng([seed, 3]).normal(size=3)
        slipped = LoadParameters(4.0, held.com + 0.025 * way / np.linalg.norm(way), held.inertia)
        stream = messages(model, held, seed=seed, change=(3.0, slipped))
        out.append(first_told(pipeline_of(model), stream) - 103.0)
    return np.array(out)


def test_a_slip_needs_less_evidence_than_any_other_load(monkeypatch):
    """Where the model foretells the torques well."""
    monkeypatch.setattr(ModelTrust, 'foretold_before', lambda self: True)
    delays = delays_of_slips()
    monkeypatch.setattr(regression, 'slip_covariance', lambda shape: np.zeros((10, 10)))
    as_any_other = delays_of_slips()
    assert (delays <= as_any_other + 1e-9).all() and delays.mean() < as_any_other.mean()


def test_a_slip_moves_the_products_like_a_moved_place():
    shape = np.array([4.0, 0.02, -0.03, 0.1, 6e-3, 1e-3, -8e-4, 8e-3, 5e-4, 5e-3])
    covariance = slip_covariance(shape)
    moved = [(products_and_jacobian_of_shape(shape + step)[0]
              - products_and_jacobian_of_shape(shape - step)[0]) / 2.0
             for step in 1e-6 * np.eye(10)[1:4]]
    expected = sum(np.outer(m, m) for m in np.array(moved) / 1e-6) * SLIP ** 2
    np.testing.assert_allclose(covariance, expected, rtol=1e-5, atol=1e-9)
    assert not covariance[0].any(), 'the mass stays'


class Witness(ChangeWindows):
    """Windows in which nothing is ever another load; asked [of each test] is what they held."""

    def evidence(self, recent, older):
        self.asked.append((recent, older))
        return -np.inf


class Watched:
    """RecentData of one load after another, and ChangeWindows that watch them."""

    def __init__(self, kind=ChangeWindows, needed=EVIDENCE, foretold=True):
        self._rng, self._foretold, self._needed = np.random.default_rng(9), foretold, needed
        self._recent, self.squares = RecentData(0, 18, memory=1e9), []
        change = np.diag([4.0] + [0.3] * 3 + [0.05] * 6) ** 2
        self.windows, self.split = kind(change, self._recent, 6), self._recent.split

    def take(self, samples, products):
        """Take samples of 0.02 s, three to a piece; windows begin anew where one ends."""
        for _ in range(samples):
            columns = self._rng.normal(size=(6, 28))
            torque = columns[:, :10] @ products + 0.3 * self._rng.normal(size=6)
            self.squares.append(torque @ torque / 0.3 ** 2)
            if self._recent.add(columns, torque, np.full(6, 1.0 / 0.3 ** 2), 0.02):
                self.windows.take(self._recent.pieces[-1])
                self.windows.begin(self._needed, self.older_of, self._foretold)

    def older_of(self, older):
        precision = older.matrix + np.eye(28)
        return Older(np.linalg.solve(precision, older.vector), precision, np.zeros((10, 10)),
                     None)


@pytest.mark.parametrize('foretold', [True, False])
def test_windows_hold_their_pieces_and_what_has_come_since(foretold):
    watched = Watched(Witness, needed=-np.inf, foretold=foretold)
    held = block(3.0).to_products()
    watched.take(3 * (LONG + 1), held)
    asked = {'pieces': set(), 'samples': set()}

    def lengths(test):
        watched.windows.asked = []
        assert not test()
        return tuple(next(n for n in range(1, 3 * LONG + 9) if sum(watched.squares[-n:])
                          == pytest.approx(recent.square, rel=1e-9))
                     for recent, _ in watched.windows.asked)

    for _ in range(12):
        watched.take(1, held)
        asked['samples'].add(lengths(watched.windows.changed_by_sample))
        if len(watched.squares) % 3 == 0:
            asked['pieces'].add(lengths(watched.windows.changed_by_pieces))
    few = (3 * SHORT, 3 * BRIEF) if foretold else (3 * SHORT,)
    longest = (*few, 3 * LONG) if foretold else few
    assert asked['pieces'] == {(*few, 3 * MIDDLE), longest}
    if not foretold:
        assert asked['samples'] == {()}
        return
    # Begun at every piece, and at every other one.
    assert {short for short, *_ in asked['samples']} == {6, 7, 8}
    assert {brief for _, brief, _ in asked['samples']} == {9, 10, 11}
    assert {middle for *_, middle in asked['samples']} == {15, 16, 17, 18, 19, 20}


@pytest.mark.parametrize('pieces, foretold, behind', [
    (12, True, BRIEF), (BRIEF, True, SHORT), (12, False, SHORT)])
def test_the_two_shortest_share_what_is_older_than_both(pieces, foretold, behind):
    watched = Watched(Witness, needed=-np.inf, foretold=foretold)
    watched.take(3 * pieces, block(3.0).to_products())
    watched.windows.asked = []
    watched.windows.changed_by_pieces()
    _, older = watched.windows.asked[0]
    np.testing.assert_array_equal(
        older.precision, watched.older_of(watched.split(behind)[0]).precision)


def test_a_sample_in_the_middle_of_a_piece_shows_another_load(monkeypatch):
    watched, blind = Watched(), Watched(foretold=False)
    for each in watched, blind:
        each.take(3 * LONG + 1, block(3.0).to_products())
    assert not watched.windows.changed_by_sample()
    for each in watched, blind:
        each.take(1, block(15.0).to_products())
    assert watched.windows.changed_by_sample(), 'at once'
    monkeypatch.setattr(change_windows, 'strongest_joint', lambda *arguments: np.inf)
    assert watched.windows.changed_by_sample(), 'all the evidence is there, whatever a joint explains'
    for each in watched, blind:
        each.take(1, block(15.0).to_products())
    assert watched.windows.changed_by_pieces() and not blind.windows.changed_by_pieces()


class Certain(ChangeWindows):
    """Windows that have so much evidence of another load."""

    told = 100.0

    def evidence(self, recent, older):
        return self.told


@pytest.mark.parametrize('foretold, needed, of_joint, expected, changed', [
    # All the evidence that is asked for, once over any joint's, or half of what may be expected.
    (False, 60.0, 39.0, 1e3, True), (False, 60.0, 41.0, 1e3, False),
    (False, 101.0, -50.0, 0.0, False), (False, 60.0, 89.0, 20.0, True),
    (False, 60.0, 91.0, 20.0, False), (False, 60.0, 99.0, -20.0, True),
    (False, 60.0, 101.0, -20.0, False),
    # Of a model that foretells more than a joint's, or all that is asked of others.
    (True, 160.0, 99.0, 1e3, True), (True, 160.0, 101.0, 1e3, False),
    (True, 170.0, -50.0, 1e3, False), (True, 99.0, 1e3, 1e3, True),
    (True, 101.0, 1e3, 1e3, False)])
def test_another_load_is_told_from_a_joint(foretold, needed, of_joint, expected, changed,
                                           monkeypatch):
    monkeypatch.setattr(change_windows, 'OF_A_MOMENT', 1.0)
    monkeypatch.setattr(change_windows, 'expected_ahead', lambda *arguments: expected)
    monkeypatch.setattr(change_windows, 'strongest_joint', lambda *arguments: of_joint)
    watched = Watched(Certain, needed, foretold)
    watched.take(3 * LONG + 3, block(3.0).to_products())
    watched.take(3, block(15.0).to_products())
    assert watched.windows.changed_by_pieces() == changed


def test_a_moment_has_to_be_ahead_of_a_joint_by_no_more_than_longer(monkeypatch):
    monkeypatch.setattr(change_windows, 'expected_ahead', lambda *arguments: 1e3)
    monkeypatch.setattr(change_windows, 'strongest_joint', lambda *arguments: 69.0)
    watched = Watched(Certain, needed=30.0, foretold=False)
    watched.take(3 * LONG + 6, block(3.0).to_products())
    watched.take(3, block(15.0).to_products())
    assert watched.windows._changed(SHORT)


def test_a_moment_is_asked_for_twice_the_evidence_where_a_joint_explains_as_much(monkeypatch):
    """Of a model that foretells, too."""
    monkeypatch.setattr(change_windows, 'strongest_joint', lambda *arguments: 1e3)
    watched = Watched(Certain, needed=60.0)
    watched.take(3 * LONG + 6, block(3.0).to_products())
    watched.take(3, block(15.0).to_products())
    assert watched.windows._changed(BRIEF) and not watched.windows._changed(SHORT)


@pytest.mark.parametrize('joint', [1, 2])
def test_a_load_is_picked_up_while_one_joint_moves(joint, monkeypatch):
    """Where a joint that fails would look alike, or nearly so."""
    monkeypatch.setattr(ModelTrust, 'foretold_before', lambda self: False)
    stream = messages(exact_model('ur10e'), LoadParameters(), 8.0, change=(5.0, block(4.0)),
                      size=0.5 * np.eye(6)[joint])

    def seen():
        return [e.stamp - 105.0 for e in feed(warm(pipeline_of(exact_model('ur10e'))), stream)
                if e.load_id > 0]

    assert 0.0 < seen()[0] < 0.5
    monkeypatch.setattr(change_windows, 'OF_EXPECTED', np.inf)
    late = seen()
    assert not late or late[0] > 0.6, 'all of the evidence is not to be had'


@pytest.fixture(scope='module')
def silent(tmp_path_factory):
    """Return an artefact whose network says nothing."""
    robot = exact_model('ur10e').robot
    return artefact_of(tmp_path_factory.mktemp('silent'), robot,
                       rounded(network_of(robot, size=0.0)))


@pytest.mark.parametrize('method', ['bayes', 'lstm'])
def test_a_large_change_is_in_the_estimate_of_the_sample_that_shows_it(method, silent,
                                                                       monkeypatch):
    """Of a model that foretells; elsewhere a sample later, and only where a piece ends."""
    model, told = exact_model('ur10e'), {}
    stream = messages(model, block(9.9), 4.0, change=(2.85, LoadParameters()))
    for foretold in (True, False):
        monkeypatch.setattr(ModelTrust, 'foretold_before', lambda self, now=foretold: now)
        pipeline = pipeline_of(model) if method == 'bayes' else pipeline_with(model, silent)
        told[foretold] = first_told(pipeline, stream)
    assert told[True] < told[False] - 0.01
