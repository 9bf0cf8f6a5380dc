"""A push that any one moment takes for another load is told from it while the hand moves."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import (block, exact_model, feed, longest_contact, Message, message_noise,
                          messages, pipeline_of, swing, torque_of, warm)
from lstm_helpers import artefact_of, network_of, pipeline_with, rounded
import numpy as np
import pinocchio as pin
import pytest

from hand_load_estimator.estimators.change import change_covariance, EVIDENCE
from hand_load_estimator.estimators.change_windows import Older
from hand_load_estimator.estimators.contact_gate import LONGEST
from hand_load_estimator.estimators.contact_watch import ContactWatch
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.estimators.model_trust import ModelTrust
from hand_load_estimator.estimators.old_load import OldLoads
from hand_load_estimator.estimators.push_watch import PushWatch
from hand_load_estimator.estimators.regression import LoadRegression, SETTLING
from hand_load_estimator.load import LoadParameters

# [s] The push begins long after the last change, and goes on for so long.
FROM, LASTS = 109.0, 1.0
MASS = 4.0


@pytest.fixture(scope='module')
def model():
    return exact_model('ur10e')


@pytest.fixture(scope='module')
def silent(model, tmp_path_factory):
    """Return an artefact whose network says nothing."""
    return artefact_of(tmp_path_factory.mktemp('silent'), model.robot,
                       rounded(network_of(model.robot, size=0.0)))


def pushed(model, stream, wrench, first=FROM, last=FROM + LASTS, rise=0.05):
    """Return Messages with a force [N] and a moment [Nm] (6,) on the hand, in base axes."""
    out = []
    for m in stream:
        share = np.clip(min((m.stamp - first) / rise, (last - m.stamp) / 0.05), 0.0, 1.0)
        torque = model.robot.hand_wrench_columns(m.position) @ wrench
        out.append(replace(m, effort=m.effort - share * torque))
    return out


def test_columns_are_the_work_of_a_force_and_a_moment(model):
    """Virtual work: of turning each joint by little, what the hand moves and turns by."""
    robot, rng = model.robot, np.random.default_rng(4)
    q, wrench = rng.normal(size=6), rng.normal(size=6)
    frame = robot.model.getFrameId(robot.load_frame)

    def hand(position):
        data = robot.model.createData()
        pin.framesForwardKinematics(robot.model, data, position)
        return data.oMf[frame]

    work = []
    for step in 1e-6 * np.eye(6):
        ahead, behind = hand(q + step), hand(q - step)
        moved = ahead.translation - behind.translation
        turned = pin.log3(ahead.rotation @ behind.rotation.T)
        work.append((wrench[:3] @ moved + wrench[3:] @ turned) / 2e-6)
    np.testing.assert_allclose(robot.hand_wrench_columns(q) @ wrench, work, atol=1e-6)


DOWN, UP, BESIDE = (0, 0, -40, 0, 0, 0), (0, 0, 40, 0, 0, 0), (0, 15, 30, 3, 0, 2)
ASIDE = (40, 0, 0, 0, 0, 0)


@pytest.mark.parametrize('seed, wrench', [(2, DOWN), (2, UP), (4, UP), (0, BESIDE), (3, BESIDE)])
def test_a_push_that_a_load_could_make_is_taken_back(model, seed, wrench):
    stream = messages(model, block(MASS), 13.0, seed=seed)
    estimates = feed(warm(pipeline_of(model)), pushed(model, stream, wrench))
    at_first = [e.stamp for e in estimates if e.load_id == 1]
    assert at_first and max(at_first) < FROM + 0.25, 'taken for a load at first'
    assert all(abs(e.mean[0] - MASS) < 0.05 for e in estimates if e.stamp > FROM + 0.25)
    told = [e for e in estimates if FROM + 0.3 < e.stamp < FROM + LASTS]
    assert all('contact' in e.reason and e.load_id == 2 for e in told)
    last = estimates[-1]
    assert last.load_id == 2 and last.status == 'DETERMINED'
    assert abs(last.mean[0] - MASS) < 4.0 * last.std[0]


def test_a_push_that_a_load_makes_all_but_a_hundredth_of_is_one(model):
    """As where the hand hardly turns: a load that is a little misread looks no other."""
    stream = messages(model, block(MASS), 13.0, seed=1)
    estimates = feed(warm(pipeline_of(model)), pushed(model, stream, DOWN))
    assert not any('contact' in e.reason for e in estimates)
    assert abs(estimates[-1].mean[0] - MASS) < 0.05


@pytest.mark.parametrize('method', ['bayes', 'lstm'])
def test_what_begins_a_contact_is_left_out_too(model, method, silent, monkeypatch):
    """The first moments of a push are below what makes a contact, and far above the noise."""
    def fresh():
        return warm(pipeline_of(model) if method == 'bayes' else pipeline_with(model, silent))

    # Of a model that foretells so slow a push is another load first, and taken back.
    monkeypatch.setattr(ModelTrust, 'foretold_before', lambda self: False)
    stream = pushed(model, messages(model, block(MASS), 11.5), UP, rise=0.2)
    assert feed(fresh(), stream)[-1].load_id == 0
    monkeypatch.setattr(LoadRegression, 'drop_newest', lambda self, stamp: None)
    assert feed(fresh(), stream)[-1].load_id > 0, 'what comes after is another'


@pytest.mark.parametrize('after', [LoadParameters(), block(2.0), block(9.0)])
@pytest.mark.parametrize('seed', range(2))
def test_another_load_is_no_push(model, after, seed):
    stream = messages(model, block(MASS), 12.0, seed=seed, change=(9.0, after))
    estimates = feed(warm(pipeline_of(model)), stream)
    assert [e.load_id for e in estimates][-1] == 1
    assert not any('contact' in e.reason for e in estimates)


@pytest.mark.parametrize('seed, takes', [(21, 0.3), (21, 0.6), (21, 1.2), (3, 0.6)])
@pytest.mark.parametrize('mass', [0.0, 9.0])
def test_a_load_that_comes_by_and_by_is_no_push(model, mass, seed, takes):
    before, after = (messages(model, block(m) if m else LoadParameters(), 13.0, seed=seed)
                     for m in (MASS, mass))
    share = [np.clip((m.stamp - FROM) / takes, 0.0, 1.0) for m in before]
    stream = [replace(a, effort=a.effort + s * (b.effort - a.effort))
              for a, b, s in zip(before, after, share)]
    estimates = feed(warm(pipeline_of(model)), stream)
    assert not any('contact: a push' in e.reason for e in estimates)
    wrong = [e.stamp for e in estimates if abs(e.mean[0] - mass) > 0.3]
    assert max(wrong) < FROM + takes + 0.6


def test_what_a_model_that_ails_takes_for_a_push_stays_a_load(model, monkeypatch):
    """... and so does what it says before any motion has told how well it foretells."""
    stream = pushed(model, messages(model, block(MASS), 13.0, seed=2), DOWN)
    for as_stated in (True, False):
        monkeypatch.setattr(ModelTrust, 'as_stated_before', lambda self, now=as_stated: now)
        estimates = feed(warm(pipeline_of(model)), stream)
        assert any('contact: a push' in e.reason for e in estimates) == as_stated


def test_a_push_beside_what_was_tared_is_told(model):
    stream = messages(model, block(MASS), 13.0, seed=2)
    pipeline = warm(pipeline_of(model))
    feed(pipeline, stream[:400])
    pipeline.tare(stream[399].stamp)
    estimates = feed(pipeline, pushed(model, stream, DOWN)[400:])
    wrong = [e.stamp for e in estimates if abs(e.mean[0]) > 0.1 and e.stamp > FROM]
    assert wrong and max(wrong) < FROM + 0.3 and estimates[-1].load_id == 2


def test_lstm_goes_back_with_bayes(model, silent):
    stream = messages(model, block(MASS), 13.0, seed=2)
    plain, ours = (feed(warm(pipeline), pushed(model, stream, UP)) for pipeline in (
        pipeline_of(model), pipeline_with(model, silent)))
    assert [e.load_id for e in ours] == [e.load_id for e in plain] and ours[-1].load_id == 2
    told = [['contact' in e.reason for e in estimates] for estimates in (plain, ours)]
    assert np.mean(np.not_equal(*told)) < 0.01
    np.testing.assert_allclose(ours[-1].mean[0], plain[-1].mean[0], atol=0.01)


@pytest.mark.parametrize('method', ['bayes', 'lstm'])
def test_a_push_taken_for_a_load_that_ends_as_a_contact_leaves_the_old_load(
        model, method, silent, monkeypatch):
    """Where none may be taken back, as just after another one that was."""
    monkeypatch.setattr(OldLoads, 'back', lambda self, *arguments: None)
    stream = messages(model, block(MASS), 13.0, seed=2)
    for wrench, begins in (DOWN, FROM), (ASIDE, FROM + 0.45):
        stream = pushed(model, stream, wrench, begins, FROM + LASTS)

    def run():
        return feed(warm(pipeline_of(model) if method == 'bayes'
                         else pipeline_with(model, silent)), stream)

    def last_wrong(estimates):
        return max(e.stamp for e in estimates if abs(e.mean[0] - MASS) > 0.1) - FROM

    estimates = run()
    assert any(e.reason.startswith('contact') for e in estimates if e.stamp > FROM + 0.45)
    assert last_wrong(estimates) < LASTS + 0.2
    assert abs(estimates[-1].mean[0] - MASS) < 4.0 * estimates[-1].std[0] < 0.1
    monkeypatch.setattr(ContactWatch, 'old_load_again', lambda self, *arguments: False)
    assert last_wrong(run()) > LASTS + 1.0


def test_of_what_came_long_before_a_contact_nothing_is_left_out(model):
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, block(MASS), 6.0))
    regression, end = pipeline.method._regression, 106.0
    kept = len(regression._recent.pieces)
    regression.drop_newest(end)
    assert len(regression._recent.pieces) == kept - 1
    regression.drop_newest(end + 0.05)
    assert len(regression._recent.pieces) == kept - 1, 'contacts that follow one another'
    regression.drop_newest(end + 30.0)
    assert len(regression._recent.pieces) == kept - 1, 'an arm that has stood'


def test_a_clock_that_is_set_back_does_not_keep_what_begins_a_contact(model):
    pipeline = warm(pipeline_of(model))
    stream = messages(model, block(MASS), 6.0)
    feed(pipeline, stream)
    regression, end = pipeline.method._regression, stream[-1].stamp
    regression.drop_newest(end)
    back = [replace(m, stamp=m.stamp - 50.0) for m in messages(model, block(MASS), 3.0, seed=4)]
    feed(pipeline, back)
    kept = len(regression._recent.pieces)
    regression.drop_newest(back[-1].stamp)
    assert len(regression._recent.pieces) == kept - 1


def stopping(model, load, at, stands):
    """Return Messages of an arm that moves like swing(), and comes to rest from `at` [s] on."""
    robot, rng = model.robot, np.random.default_rng(8)
    times = np.arange(round((at + stands) / 0.01)) * 0.01
    # Its time runs ever slower: by half a second it has come to a stop.
    left = np.clip((times - at) / 0.5, 0.0, 1.0)
    rate = 1.0 - left ** 2 * (3.0 - 2.0 * left)
    slowing = np.gradient(rate, times)
    q, v, a = swing(robot, np.cumsum(rate) * 0.01, seed=2)
    v, a = v * rate[:, None], a * rate[:, None] ** 2 + v * slowing[:, None]
    torque = torque_of(model, q, v, a, 0.01, 25.0, [(0, load)])
    torque = torque + rng.normal(size=torque.shape) * message_noise(robot)
    effort = torque / robot.effort.torque_constants
    return [Message(100.0 + t, robot.joints, *row) for t, *row in zip(times, q, v, effort)]


def test_a_push_goes_on_while_the_arm_comes_to_rest(model):
    """A standing arm's torque would be another load's as well."""
    stream = stopping(model, block(MASS), 9.5, 3.0)
    estimates = feed(warm(pipeline_of(model)), pushed(model, stream, BESIDE, 109.0, 111.5))
    told = [e for e in estimates if 109.35 < e.stamp < 110.8]
    assert all('contact' in e.reason and abs(e.mean[0] - MASS) < 0.05 for e in told)


def test_a_push_soon_after_another_load_is_let_be(model):
    """The load may be misread, and what comes of that look like a push."""
    stream = messages(model, block(MASS), 13.0, seed=2, change=(6.0, block(MASS + 2.0)))
    estimates = feed(warm(pipeline_of(model)), pushed(model, stream, DOWN))
    told = [e for e in estimates if FROM + 0.3 < e.stamp < FROM + LASTS]
    assert not any(e.reason.startswith('contact: a push') for e in told)
    assert max(abs(e.mean[0] - MASS - 2.0) for e in told) > 1.0
    assert abs(estimates[-1].mean[0] - MASS - 2.0) < 0.1


@pytest.mark.parametrize('wrench', [DOWN, UP])
def test_a_push_that_never_ends_is_told_for_eight_seconds_at_a_time(model, wrench):
    stream = messages(model, block(MASS), 28.0, seed=2)
    estimates = feed(warm(pipeline_of(model)), pushed(model, stream, wrench, FROM, 200.0))
    assert any('contact' in e.reason for e in estimates)
    assert longest_contact(estimates) < LONGEST + 0.1


class Watched:
    """A PushWatch of an arm that moves, or hardly does, and a torque that begins at once."""

    def __init__(self, model, speed, longest=1.0):
        self._robot, self._speed, self._time = model.robot, speed, 0.0
        self._rng, prior = np.random.default_rng(2), load_prior(model.robot)
        self.watch = PushWatch(model.robot, prior, change_covariance(prior), 0)
        self._held = block(MASS).to_products()
        self.watch.begin(Older(self._held, np.diag(np.full(10, 1e6)), np.zeros((10, 10)), None),
                         EVIDENCE, longest)

    def take(self, seconds, wrench=(0, 0, 0, 0, 0, 0), more=None):
        """Let a wrench (6,) act, or a load's products beside it; return what was told."""
        held, out = self._held + (0.0 if more is None else more.to_products()), []
        for _ in range(round(seconds / 0.02)):
            self._time += 0.02
            angle = 1.0 + self._speed * np.sin(3.0 * self._time) * np.linspace(1.0, 0.5, 6)
            speed = self._speed * 3.0 * np.cos(3.0 * self._time) * np.linspace(1.0, 0.5, 6)
            columns = self._robot.load_regressor(angle, speed, -9.0 * (angle - 1.0))
            difference = (columns @ held + self._robot.hand_wrench_columns(angle) @ wrench
                          + 0.3 * self._rng.normal(size=6))
            out.append(self.watch.take(SimpleNamespace(q=angle, dt=0.02), columns, difference,
                                       np.full(6, 0.02 * 0.3 ** 2)))
        return out


def test_what_the_filter_still_shows_is_not_asked(model):
    watched = Watched(model, 0.3)
    watched.watch._evidence = None
    assert not any(watched.take(SETTLING - 0.01, DOWN))


def test_a_push_is_told_and_another_load_ends_the_watch(model):
    pushed, loaded = Watched(model, 1.0), Watched(model, 1.0)
    told = pushed.take(0.3, DOWN)
    assert told[-1] and pushed.watch.begun
    assert not any(loaded.take(0.3, more=block(3.0))) and not loaded.watch.begun


def test_of_a_hand_that_hardly_moves_nothing_is_told(model):
    watched = Watched(model, 1e-3)
    assert not any(watched.take(0.9, DOWN)) and watched.watch.begun
    watched.take(0.2, DOWN)
    assert not watched.watch.begun, 'not for longer than it was told to'


def test_a_push_that_gives_way_to_a_load_is_told_no_more(model):
    watched = Watched(model, 1.0, longest=3.0)
    assert watched.take(1.5, DOWN)[-1]
    assert not watched.take(0.5, more=block(3.0))[-1]
