"""Which load is counted on: estimate while trusted, rated load otherwise."""

import numpy as np
import pytest
from control_helpers import FakeModel, covariance_of, load_vector

from hand_load_estimator.control.fallback import FallbackSettings, LoadPolicy, usable_estimate

ROBOT = FakeModel().robot
RATED = ROBOT.rated_load.mass


class Feed:
    """Feeds a LoadPolicy every 10 ms, as the node's timer and the estimator do."""

    def __init__(self):
        self.policy, self.now = LoadPolicy(ROBOT, FallbackSettings(0.5, 0.5, 0.5)), 100.0

    def run(self, seconds, status='DETERMINED', load_id='1', mass=3.0, moving=False,
            residuals=True):
        for _ in range(round(seconds / 0.01)):
            self.now += 0.01
            if status:
                self.policy.estimate(self.now, load_vector(mass), covariance_of(0.05))
                self.policy.status(self.now, status, load_id)
            if residuals:
                self.policy.residual(self.now)
            self.policy.update(self.now, moving)
        return self.policy


def test_before_any_estimate_the_rated_load_counts():
    policy = Feed().run(0.2, status=None)
    assert not policy.trusted and policy.caution == 1.0
    assert policy.belief.source == 'rated' and policy.belief.mean[0] == RATED


def test_a_trusted_estimate_counts_and_caution_fades_slowly():
    feed = Feed()
    assert feed.run(0.02).belief.source == 'estimate'
    assert feed.policy.caution > 0.9
    assert 0.3 < feed.run(0.25).caution < 0.7
    assert feed.run(0.4).caution == 0.0
    assert feed.policy.belief.mean[0] == 3.0


@pytest.mark.parametrize('status', ['STALE_INPUT', 'MODEL_MISMATCH', 'LOAD_CHANGED',
                                    'WAITING_FOR_MOTION', 'NO_DATA'])
def test_any_other_status_falls_back_at_once(status):
    feed = Feed()
    feed.run(1.0)
    feed.policy.status(feed.now, status, '1')
    assert feed.policy.belief.source == 'rated' and feed.policy.caution == 1.0
    assert status in feed.policy.reason


def test_silence_falls_back_after_the_timeout_and_says_how_old():
    feed = Feed()
    feed.run(1.0)
    assert feed.run(0.4, status=None).trusted
    assert not feed.run(0.2, status=None).trusted
    assert 's old' in feed.policy.reason and feed.policy.caution == 1.0


def test_a_status_without_estimates_is_not_enough():
    feed = Feed()
    feed.run(1.0)
    for _ in range(80):
        feed.now += 0.01
        feed.policy.status(feed.now, 'DETERMINED', '1')
        feed.policy.update(feed.now, False)
    assert not feed.policy.trusted


def test_without_residual_torques_the_rated_load_counts():
    feed = Feed()
    assert not feed.run(1.0, residuals=False).trusted
    assert feed.policy.blind == 'no residual torque has arrived'
    assert feed.run(1.0).trusted and not feed.policy.blind
    assert feed.run(0.15, residuals=False).trusted
    feed.run(0.1, residuals=False)
    assert feed.policy.caution == 1.0 and not feed.policy.trusted
    assert 'residual torque is 0.2' in feed.policy.reason == feed.policy.blind


def test_an_expected_change_waits_for_the_estimators_count():
    feed = Feed()
    feed.run(1.0)
    feed.policy.expect_change()
    assert feed.policy.belief.source == 'rated'
    assert not feed.run(3.0).trusted, 'at rest nothing shows whether the load has changed'
    assert feed.run(0.02, load_id='2', mass=8.0).trusted
    assert feed.policy.belief.mean[0] == 8.0


def test_an_expected_change_that_did_not_happen_is_believed_after_motion():
    feed = Feed()
    feed.run(1.0)
    feed.policy.expect_change()
    assert not feed.run(0.4, moving=True).trusted
    assert feed.run(0.2, moving=True).trusted


def test_motion_that_the_estimator_said_nothing_of_confirms_nothing():
    feed = Feed()
    feed.run(1.0)
    feed.policy.expect_change()
    feed.run(2.0, status=None, moving=True)
    assert not feed.run(0.4, moving=True).trusted
    assert feed.run(0.2, moving=True).trusted


def test_a_clock_that_jumps_back_does_not_trust_the_future():
    feed = Feed()
    feed.run(1.0)
    feed.policy.update(feed.now - 50.0, False)
    assert not feed.policy.trusted


@pytest.mark.parametrize('change, why', [
    (lambda m, c: (m[:9], c), 'estimate_size'), (lambda m, c: (m, c.ravel()), 'estimate_size'),
    (lambda m, c: (m * np.nan, c), 'estimate_not_finite'),
    (lambda m, c: (m, c + np.inf), 'estimate_not_finite'),
    (lambda m, c: (m, -c), 'covariance_not_positive'), (lambda m, c: (m, c), ''),
    (lambda m, c: (m - 2.2, c), ''), (lambda m, c: (m - 2.4, c), 'negative_mass')])
def test_unusable_estimates_are_named(change, why):
    assert usable_estimate(*change(load_vector(2.0), covariance_of(0.1))) == why
