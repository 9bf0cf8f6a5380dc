"""The motion between two samples, as it was measured."""

from dataclasses import replace

import numpy as np
import pytest

from hand_load_estimator.course import (MeasuredCourse, SHARES, STANDS, STEPS, TURNED,
                                        Ways)
from hand_load_estimator.motion import Motion, MotionFilter


def heard(rate, with_velocity=True):
    """Return a Motion of two joints that turn around, behind the filter."""
    motion, samples = MotionFilter(2), []
    for t in np.arange(0.0, 2.0, 1.0 / rate):
        v = np.array([0.3 * np.cos(20.0 * t), -0.4 * np.sin(9.0 * t)])
        q = np.array([0.015 * np.sin(20.0 * t), 0.4 / 9.0 * np.cos(9.0 * t)])
        samples.append(motion.update(t, q, v if with_velocity else np.full(2, np.nan), 0.0 * q))
    return Motion.of([s for s in samples if s is not None])


@pytest.mark.parametrize('rate', [100.0, 250.0, 500.0, 1000.0])
@pytest.mark.parametrize('with_velocity', [True, False])
def test_it_is_the_motion_at_even_moments(rate, with_velocity):
    motion = heard(rate, with_velocity)
    times = motion.stamp[:, None] + motion.dt[:, None] * (SHARES - 1.0)
    assert motion.course.shape == (len(motion.stamp), 2, STEPS, 2)
    q = np.stack([0.015 * np.sin(20.0 * times), 0.4 / 9.0 * np.cos(9.0 * times)], axis=-1)
    # Straight lines between messages are off by a dt^2 / 8.
    np.testing.assert_allclose(motion.course[:, 0], q, atol=6.0 / 8.0 / rate ** 2 + 1e-12)
    v = np.stack([0.3 * np.cos(20.0 * times), -0.4 * np.sin(9.0 * times)], axis=-1)
    np.testing.assert_allclose(motion.course[:, 1], v, atol=0.0015 if rate > 100.0 else 0.02)


def test_the_next_begins_where_the_last_ended():
    course = MeasuredCourse(0.0, np.zeros((2, 1)), False)
    course.hear(0.004, np.full((2, 1), 1.0))
    assert course.sampled()[0, :, 0] == pytest.approx(SHARES)
    course.hear(0.012, np.full((2, 1), 3.0))
    np.testing.assert_allclose(course.sampled()[0, :, 0], 1.0 + 2.0 * SHARES)


def test_messages_that_come_unevenly_are_joined_by_straight_lines():
    course = MeasuredCourse(1.0, np.zeros((2, 1)), False)
    for stamp in (1.001, 1.009, 1.016, 1.02):
        course.hear(stamp, np.full((2, 1), stamp - 1.0))
    np.testing.assert_allclose(course.sampled(), np.tile(0.02 * SHARES[:, None], (2, 1, 1)))


def test_where_one_sample_has_none_the_motion_has_none():
    motion = heard(500.0)
    samples = list(motion.samples())
    np.testing.assert_array_equal(Motion.of(samples).course, motion.course)
    assert motion.part(slice(3, 9)).course.shape[0] == 6
    assert Motion.of([*samples[:3], replace(samples[3], course=None)]).course is None


def ways_along(q):
    ways = Ways(q[0])
    return np.concatenate([ways.along(own, 0.02, 10) for own in q.reshape(-1, STEPS, 1)])


@pytest.mark.parametrize('noise', [5e-6, 3e-5, 1e-4, 1e-3])
def test_noise_of_a_standing_joint_is_hardly_any_way(noise):
    """Two minutes of rest."""
    q = 0.3 + noise * np.random.default_rng(1).normal(size=(24_000, 1))
    assert np.abs(ways_along(q)).sum() < 5.0 * max(STANDS, 8.0 * noise)


@pytest.mark.parametrize('acceleration, late', [(3.0, 1e-4), (0.02, STANDS + 1e-5)])
def test_all_of_a_way_counts_once_a_joint_has_turned(acceleration, late):
    """A quick reversal is told at once, one as slow as noise when it is beyond noise."""
    t = np.arange(-400, 400) * 0.005
    q = -0.5 * acceleration * t[:, None] ** 2
    ways = ways_along(q)
    assert ways[:401].sum() == pytest.approx(q[400] - q[0])
    turned = np.flatnonzero(ways[401:, 0])[0] + 401
    assert TURNED <= -q[turned, 0] < late + TURNED
    assert ways[401:].sum() == pytest.approx(q[-1] - q[400])


def test_noise_is_told_after_a_start_that_stood_still_to_the_bit():
    rng = np.random.default_rng(3)
    q = np.concatenate([np.full((2000, 1), 0.3), 0.3 + 1e-4 * rng.normal(size=(12_000, 1))])
    assert np.abs(ways_along(q)).sum() < 5.0 * 8.0 * 1e-4


@pytest.mark.parametrize('kind', ['jitter', 'held'])
def test_what_is_uneven_in_motion_is_no_noise_of_an_encoder(kind):
    """Stamps off by a millisecond, or positions that come four times: a reversal is seen soon."""
    t, rng = 0.005 * np.arange(4000), np.random.default_rng(5)
    if kind == 'held':
        q = 0.3 * np.sin(2.0 * np.floor(t / 0.008) * 0.008)
    else:
        q = 0.3 * np.sin(2.0 * (t + 1e-3 * rng.normal(size=len(t))))
    ways = ways_along(q[:, None])[:, 0]
    for turned in (np.arange(3, 12) + 0.5) * np.pi / 2.0:
        where = (t > turned) & (t < turned + 0.3)
        sign = np.sign(np.cos(2.0 * (turned + 0.1)))
        first = t[where][np.flatnonzero(np.sign(ways[where]) == sign)[0]]
        assert 0.3 * (1.0 - np.cos(2.0 * (first - turned))) < 4.0 * STANDS
