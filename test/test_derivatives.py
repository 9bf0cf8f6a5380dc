"""Velocity and acceleration of least noise from position and velocity."""

import numpy as np
import pytest

from hand_load_estimator.derivatives import Derivatives
from hand_load_estimator.motion import BANDWIDTH, MotionFilter

RATE = 500.0


def accelerations(position_noise, velocity_noise, quantum=1e-9, rest=0.0):
    """Return stamps, errors [rad/s^2] (N,) of twenty seconds of sine after a rest, and share."""
    rng, out = np.random.default_rng(3), []
    motion, exact = MotionFilter(1), MotionFilter(1)
    for k in range(int(20.0 * RATE)):
        t = k / RATE
        s = 2.0 * max(t - rest, 0.0)
        q, v = np.array([1.0 - np.cos(s)]), np.array([2.0 * np.sin(s)])
        read = np.round((q + position_noise * rng.standard_normal(1)) / quantum) * quantum
        sample = motion.update(t, read, v + velocity_noise * rng.standard_normal(1), q)
        true = exact.update(t, q, v, q)
        if sample is not None and not sample.fresh:
            out.append((t, sample.a[0] - true.a[0]))
    return (*np.array(out).T, motion._derivatives.share[0])


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


# RMS of the acceleration of white noise by Parseval: of a velocity, and of a position.
OF_VELOCITY = np.sqrt(BANDWIDTH ** 3 / RATE / 16.0)
OF_POSITION = np.sqrt(3.0 * BANDWIDTH ** 5 / RATE / 16.0)


def test_a_fine_encoder_beside_a_noisy_velocity_halves_the_noise():
    t, error, share = accelerations(6e-6, 2e-3)
    velocity, position = 2e-3 * OF_VELOCITY, 6e-6 * OF_POSITION
    best = 1.0 / np.hypot(1.0 / velocity, 1.0 / position)
    assert best < 0.5 * velocity
    assert rms(error[t > 2.0]) == pytest.approx(best, rel=0.15)
    assert share == pytest.approx((best / position) ** 2, abs=0.1)


def test_a_coarse_encoder_is_left_out_also_after_a_long_rest():
    t, error, share = accelerations(0.0, 2e-3, quantum=5e-4, rest=8.0)
    assert share < 0.05
    assert rms(error[t > 8.0]) < 1.1 * 2e-3 * OF_VELOCITY


def test_without_anything_seen_it_is_the_velocitys():
    derivatives = Derivatives(2)
    velocity = np.array([[1.0, 1.0], [3.0, 4.0]])
    np.testing.assert_array_equal(derivatives.update(0.5 * velocity, velocity), velocity)


def test_joints_weigh_by_their_own_noise_and_keep_it_over_a_gap():
    rng, derivatives = np.random.default_rng(0), Derivatives(2)
    fine, coarse, moves = np.array([0.01, 0.1]), np.array([0.1, 0.01]), np.ones(2)
    for k in range(300):
        derivatives.update(np.array([moves, fine * rng.standard_normal(2)]),
                     np.array([moves, coarse * rng.standard_normal(2)]))
    share = derivatives.share
    assert share[0] > 0.9 and share[1] < 0.1
    derivatives.restart()
    # What lies on both sides of the gap is not taken for noise.
    for _ in range(4):
        derivatives.update(np.array([moves, 1e3 * moves]), np.array([moves, -1e3 * moves]))
    np.testing.assert_array_equal(derivatives.share, share)
